"""`report`: one page that draws what the runs hold, asks for nothing, and takes no text for markup. In headless Chromium."""
import json
import re
import shutil

import pytest

from support import *

BROWSER = shutil.which("chromium")
SWITCHES = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
            "--disable-component-update", "--disable-sync", "--virtual-time-budget=20000"]
# What the charts hold, for the test to read: added to a copy of the page.
PROBE = """<script>setTimeout(() => {
    const pre = document.createElement("pre");
    pre.id = "probe";
    pre.textContent = JSON.stringify({ objects: document.getElementById("report").textContent.includes("[object"), requests: performance.getEntriesByType("resource").map((e) => e.name), charts: [...document.querySelectorAll(".chart")].map((c) => ({
        chart: c.dataset.chart, drawn: c.querySelector("svg.main-svg") !== null,
        traces: (c.data || []).map((t) => ({ name: t.name, symbols: [].concat((t.marker || {}).symbol || []), x: Array.from(t.x || []), y: Array.from(t.y || []),
            z: (t.z || []).map((line) => Array.from(line)) })) })),
        wider: [...document.querySelectorAll("main > *, main section > *")].filter((e) => e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map((e) => e.tagName + "." + e.className) });
    document.body.append(pre);
}, 3000);</script></body>"""
folder = workspace()


def opened(page):
    """The page after its scripts ran: (attributes of the root, charts, requests beyond the file)."""
    assert BROWSER, "chromium is needed to open the report"
    copy = folder / "probe.html"
    copy.write_text(page.read_text().replace("</body>", PROBE))
    done = subprocess.run([BROWSER, *SWITCHES, f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--dump-dom",
                           f"file://{copy}"], capture_output=True, text=True, timeout=120)
    dom = done.stdout
    root = re.search(r"<html[^>]*>", dom).group(0)
    probe = re.search(r'<pre id="probe">(.*?)</pre>', dom, re.S)
    assert probe is not None, f"the page runs to its end: {dom[-300:]}"
    text = probe.group(1).replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert not console, f"nothing on the console: {console}"
    found = json.loads(text)
    # What the page's own policy refuses would stand in data-failures.
    return root, found["charts"], [u for u in found["requests"] if not u.startswith(("data:", "blob:"))], dom


def overflow(dom):
    """Elements that reach beyond the page's width."""
    return json.loads(re.search(r'"wider":(\[.*?\])', dom.replace("&gt;", ">")).group(1))


def shown(dom):
    """The page without its scripts."""
    return re.sub(r"<script.*?</script>", "", dom, flags=re.S)


def same(found, wanted):
    return len(found) == len(wanted) and all(abs(a - b) <= 1e-9 * abs(b) for a, b in zip(found, wanted))


@pytest.fixture(scope="module")
def reported():
    # A run with a title and a layer that try to be markup.
    study = folder / "study.toml"
    shutil.copy(ROOT / "grids" / "captif-p1-fwd.csv", folder)
    text = (ROOT / "grids" / "captif-p1-fwd.toml").read_text()
    text = re.sub(r'^title = .*$', 'title = "<script>window.pwned = 1</script><img src=x onerror=alert(1)>"', text, flags=re.M)
    text = text.replace('"asphalt"', '"</script><b>"').replace('"subgrade"', '"\'); drop table run; --"').replace('"subgrade.', '"\'); drop table run; --.')
    study.write_text(text)
    run_folder = folder / "run"
    assert run("fit", study, "--explore", "48", "--starts", "3", "--out", run_folder).returncode == 0, "fit"
    assert run("map", study, "--design", "sobol", "--points", "32", "--out", run_folder).returncode == 0, "map"
    assert run("sensitivity", study, "--samples", "0", "--out", run_folder).returncode == 0, "sensitivity"
    made = run("report", run_folder)
    page = run_folder / "report.html"
    assert made.returncode == 0 and page.exists(), f"a report: {made.stderr}"
    return run_folder, page


def test_nothing_of_a_study_is_markup(reported):
    _, page = reported
    assert page.stat().st_size < 6e6, "smaller than 6 MB"
    html = page.read_text()
    assert "</script><b>" not in html and "<img src=x" not in html, "nothing of a study is markup"
    assert not re.search(r'(src|href)="https?:', html.split('<script type="application/json"')[0]), "no reference to elsewhere"


@pytest.fixture(scope="module")
def survey_folder():
    survey_folder = folder / "road"
    assert run("survey", ROOT / "grids" / "road-example.csv", "--out", survey_folder).returncode == 0, "survey"
    assert run("report", survey_folder, "--out", folder / "road.html").returncode == 0 and (folder / "road.html").exists(), "a report elsewhere"
    return survey_folder


def test_what_holds_no_run_is_said(survey_folder):
    for wrong, word in ((folder / "nothing", "no such folder"), (folder, "holds no run")):
        done = run("report", wrong)
        assert done.returncode == 2 and word in done.stderr, f"says '{word}': {done.stderr}"
    (survey_folder / "fit.json").write_text("[1")
    done = run("report", survey_folder)
    assert done.returncode == 2 and "fit.json" in done.stderr, f"names a file that is no result: {done.stderr}"


@pytest.fixture(scope="module")
def browsed(reported):
    _, page = reported
    root, charts, requests, dom = opened(page)
    return root, charts, requests, dom


def test_the_page_opens_and_asks_for_nothing(browsed):
    root, charts, requests, dom = browsed
    assert "data-failures" not in root, f"no failure: {root}"
    assert not requests, f"no request leaves the page: {requests}"
    assert len(charts) > 10 and all(c["drawn"] for c in charts), f"every chart is drawn: {[c['chart'] for c in charts if not c['drawn']]}"
    assert "pwned" not in root and dom.count("<img") == 0, "the title stayed text"


@pytest.fixture(scope="module")
def fit(reported):
    run_folder, _ = reported
    return json.loads((run_folder / "fit.json").read_text())


def test_charts_hold_what_was_measured_and_modelled(browsed, fit):
    _, charts, _, _ = browsed
    measured = next(c for c in charts if c["chart"] == "measured")
    rows = sorted((r for r in fit["responses"] if "measured" in r), key=lambda r: r["x_mm"])
    assert same(measured["traces"][0]["y"], [r["measured"] for r in rows]), "the chart holds the measured deflections"
    modelled = [t for t in measured["traces"] if t["name"] == "best fit"]
    assert any(same(t["y"], [r["value"] for r in rows]) for t in modelled), "the chart holds the modelled deflections"
    curve = next(t for t in modelled if len(t["y"]) > len(rows))
    at_sensors = [y for x, y in zip(curve["x"], curve["y"]) if x in [r["x_mm"] for r in rows]]
    assert same(at_sensors, [r["value"] for r in rows]) and len(curve["y"]) > 40, "and a curve that passes through them"


def test_timings_count_the_forward_runs(reported, browsed):
    run_folder, _ = reported
    _, _, _, dom = browsed
    for command in ("fit", "map"):
        computed = len(json.loads(run("export", run_folder, "--command", command, "--format", "json").stdout)["evaluations"])
        assert re.search(rf"<td[^>]*>pavescape {command} [^<]*</td><td[^>]*>\d+</td><td[^>]*>{computed}</td>", dom), \
            f"the timings count the {computed} forward runs of {command}"


def test_the_waterfall_holds_the_ends_of_the_searches(browsed, fit):
    _, charts, _, dom = browsed
    ends = sorted(e["misfit"] for e in fit["ends"])
    waterfall = [c for c in charts if c["chart"] == "waterfall"]
    if ends[-1] - ends[0] <= 1e-3 * ends[0]:
        assert not waterfall and f"All {len(ends)} searches ended at the misfit" in dom, "searches that agree are a sentence"
    else:
        assert same(waterfall[0]["traces"][0]["y"], ends), "the waterfall holds the ends of the searches"


def test_the_landscape_of_a_map_shows_its_points_and_no_tiles(reported, browsed):
    run_folder, _ = reported
    _, charts, _, _ = browsed
    points = [e for e in json.loads(run("export", run_folder, "--command", "map", "--format", "json").stdout)["evaluations"]]
    of_last_two = sorted(tuple(e["parameters"][-2:]) for e in points if e["status"] == "converged")
    traces = [c for c in charts if c["chart"] == "pair"][-1]["traces"]
    computed = next(t for t in traces if t["name"] == "computed")
    found = sorted(zip(computed["x"], computed["y"]))
    assert len(found) == len(of_last_two) > 1 and all(abs(a / b - 1) < 1e-9 for p, q in zip(found, of_last_two) for a, b in zip(p, q)), "every point that was computed"
    assert not any(t["z"] for t in traces), "nothing between them"


def test_text_is_text_and_nothing_is_too_wide(browsed):
    _, _, _, dom = browsed
    assert '"objects":false' in dom, "no object is printed as such"
    assert "(not determined)" in dom, "a standard error beyond half of the range of the study is said so"
    assert overflow(dom) == [], f"nothing is wider than the page: {overflow(dom)}"


def test_a_road(survey_folder):
    root, charts, requests, dom = opened(folder / "road.html")
    survey = json.loads((survey_folder / "survey.json").read_text())
    good = [s for s in survey["stations"] if "D0_um" in s]
    assert "data-failures" not in root and not requests, f"the road opens: {root} {requests}"
    held = charts[0]["traces"][0]["y"] # to the six digits of a page
    assert len(held) == len(good) and all(abs(y / s["D0_um_at_common_pressure"] - 1) < 1e-5 for y, s in zip(held, good)), "the strip chart holds D0"
    remarks = [r for s in survey["stations"] for r in s["remarks"]]
    assert any("450 mm" in r for r in remarks) and all(r.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") in dom for r in remarks), \
        "the report has the remarks"
    assert f"road-example.csv, line {survey['stations'][0]['line']}" in dom, "the report says where a station stands in its file"
    assert "rigid rough floor" not in shown(dom), "without a study there is no floor"
    assert "Homogeneous sections" in dom and "SCI" in dom, "the report has sections and indices"


def test_two_lanes():
    # Two lanes, a rejected station, a study on a half-space, outputs and what is not determined: a trace a lane, marks, tables.
    two_lanes = folder / "lanes.csv"
    bowls = {"L": "473.5,309.5,209.8,158.3,126.4,104.1,87.6", "R": "600,380,250,182,144,117,98"}
    two_lanes.write_text("station,lane,chainage_m,radius_mm,load_kN,D0_um,D300_um,D600_um,D900_um,D1200_um,D1500_um,D1800_um\n" +
                         "".join(f"{lane}{k},{lane},{50 * k},150,40,{bowls[lane]}\n" for lane in "LR" for k in range(3)) + "L9,L,150,150,40,500,300,400,200,100,50,20\n")
    study = 'schema = 1\n[section]\nbottom = "half-space"\n'
    for name, thickness, modulus in (("asphalt", 170, 1200), ("base", 575, 200), ("subgrade", 4255, 60)):
        study += (f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2000\nk0 = 0.5\nlaw = "linear"\n'
                  f'modulus_MPa = {modulus}\npoisson = 0.4\n')
    study += '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 566\n[data]\nmisfit = "relative"\n'
    for name, low, high in (("asphalt", 1100, 1300), ("base", 50, 800), ("subgrade", 20, 200)):  # so narrow a range of asphalt tells nothing
        study += f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
    study += '[[outputs]]\nname = "base strain"\nload = "fwd"\nquantity = "strain_zz"\ndepth_mm = 400\n'
    (folder / "lanes.toml").write_text(study)
    assert run("survey", two_lanes, "--study", folder / "lanes.toml", "--out", folder / "lanes").returncode == 0, "survey of two lanes"
    assert run("report", folder / "lanes").returncode == 0, "report of two lanes"
    root, charts, requests, dom = opened(folder / "lanes" / "report.html")
    survey = json.loads((folder / "lanes" / "survey.json").read_text())
    assert "data-failures" not in root and not requests, f"two lanes open: {root} {requests}"
    named = [[t["name"] for t in c["traces"] if t.get("name")] for c in charts]
    by_lane = [n for n in named if n and not {"0 mm", "median"} & set(n)]  # but for residuals by sensor and the surface modulus
    assert len(by_lane) >= 7 and all({"lane L", "lane R"} <= set(n) for n in by_lane), f"a trace for every lane in every chart: {named}"
    wanted = ["parameters" in s and not s["parameters"]["asphalt.modulus_MPa"]["determined"] for s in survey["stations"] if "fit" in s]
    marks = [[m.endswith("-open") for t in c["traces"] for m in t["symbols"]] for c in charts]
    assert any(wanted) and wanted in marks, f"what is not determined is open: {marks}"
    assert "rigid rough floor" not in shown(dom) and "(?)" in shown(dom) and "base strain" in dom, "the bottom is the study's; undetermined values are marked; outputs"
    assert "rises" in dom and "lanes.csv, line 8" in dom, "why a station is rejected, and where it stands"
    assert overflow(dom) == [], f"nothing is wider than the page: {overflow(dom)}"
