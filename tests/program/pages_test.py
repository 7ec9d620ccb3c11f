"""The page of every kind of run in headless Chromium, 1400 and 400 px wide and printed on A4: no table is cut off, nothing is printed as
[object, nothing is on the console, every chart is drawn."""
import functools
import re

import pytest

from browser import CHROMIUM, Browser
from support import *

folder = workspace()
SIGMAS = [0.04, 20.0, 0.01, 0.00004]
lines = DATA.strip().splitlines()
data = "\n".join(lines[:2] + [line + str(sigma) for line, sigma in zip(lines[2:], SIGMAS)]) + "\n"
study = write_study(folder / "s", STUDY.replace('misfit = "log"', 'misfit = "weighted"'), data)
# Linear layers: quick enough for what needs many runs.
linear = folder / "linear.toml"
lives = folder / "lives.toml"
RUNS = {
    "fit": ("fit", linear, "--explore", 32, "--starts", 4),
    "map": ("map", linear, "--design", "sobol", "--points", 64),
    "unique": ("unique", linear, "--explore", 32, "--verify", 6, "--landscape"),
    "sample": ("sample", linear, "--samples", 800),
    "sensitivity": ("sensitivity", linear, "--samples", 16),
    "diagnose": ("diagnose", linear),
    "compare": ("compare", study, "--laws", "uzan,k-theta", "--explore", 16, "--verify", 3),
    "design": ("design", lives, "--explore", 32, "--verify", 4),
    "survey": ("survey", ROOT / "grids" / "road-example.csv"),
}
# What stands out of the page or of its own box. The text of a study may scroll, and on a screen what a road has of its stations.
CLIPPED = """[...document.querySelectorAll("main *")].filter((e) => !e.closest(".chart, pre, script, noscript") && !["MAIN", "OPTION"].includes(e.tagName)).filter((e) => {
    const road = document.querySelector("[data-chart=strip]") !== null && matchMedia("screen").matches;
    if (road && e.closest(".wide")) return false;
    return (e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0 && getComputedStyle(e).display !== "inline" && !["TBODY", "THEAD", "TR"].includes(e.tagName))
        || e.getBoundingClientRect().right > document.documentElement.clientWidth + 1;
}).map((e) => e.tagName + "." + e.className + ": " + e.textContent.slice(0, 60))"""


@pytest.fixture(scope="module", autouse=True)
def linear_study():
    assert run("new", linear, "--linear").returncode == 0, "new"
    criteria = "".join(f'[[criteria]]\nname = "{name}"\nlaw = "{law}"\naxle = "fwd"\ntraffic_per_year = 1.0e5\ngrowth = 0.03\npassed = 2e5\n'
                       for name, law in (("rutting", "austroads-subgrade"), ("cracking", "asphalt-institute-fatigue")))
    lives.write_text(linear.read_text() + criteria)


@pytest.fixture(scope="module")
def browser():
    assert CHROMIUM, "chromium is needed to open the pages"
    browser = Browser(folder / "profile")
    yield browser
    browser.close()


@functools.cache
def reported(name):
    """The folder of a run and its page."""
    out = folder / name
    done = run(*RUNS[name], "--out", out)
    assert done.returncode in (0, 1) and (out / f"{name}.json").exists(), f"{name} runs: {done.returncode} {done.stderr[-300:]}"
    made = run("report", out)
    assert made.returncode == 0, f"report of {name}: {made.stderr}"
    return out


@pytest.mark.parametrize("name", RUNS)
def test_a_page_is_whole_at_every_width(browser, name):
    out = reported(name)
    for width, media in ((1400, "screen"), (400, "screen"), (718, "print")):  # 718 px: A4 less margins of 1 cm
        browser.console.clear()
        browser.resize(width, 900)
        browser.call("Emulation.setEmulatedMedia", media=media)
        browser.open((out / "report.html").as_uri())
        assert browser.wait("[...document.querySelectorAll('.chart')].every((c) => c.querySelector('svg.main-svg'))", 60), f"{name}: every chart is drawn"
        assert browser.evaluate("document.documentElement.dataset.failures") is None, f"{name}: {browser.evaluate('document.documentElement.dataset.failures')}"
        assert browser.console == [], f"{name}, {width} px: the console: {browser.console}"
        assert browser.evaluate("document.querySelectorAll('h2').length") > 0, f"{name} has a part"
        assert "[object" not in browser.evaluate("document.body.innerText"), f"{name}: no object is printed as such"
        clipped = browser.evaluate(CLIPPED)
        assert clipped == [], f"{name}, {width} px on {media}: cut off: {clipped[:4]}"
        assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth"), f"{name}: no wider than {width} px on {media}"
    browser.call("Emulation.setEmulatedMedia", media="screen")
    if os.environ.get("PAVESCAPE_SHOTS"):
        for width in (1400, 400):
            browser.resize(width, 900)
            time.sleep(1)
            browser.screenshot(pathlib.Path(os.environ["PAVESCAPE_SHOTS"]) / f"{name}-{width}.png")


def test_the_page_of_unique(browser):
    out = reported("unique")
    # The page of `unique`: its first sentence once; whole pairs below the diagonal and profiles on it; no figure of minima where there is one.
    unique = json.loads((out / "unique.json").read_text())
    browser.resize(1400, 900)
    browser.open((out / "report.html").as_uri())
    assert browser.wait("document.querySelector('[data-chart=landscape] svg.main-svg') !== null", 60), "the landscape is drawn"
    verdict = unique["findings"][0].split(":")[0]
    assert browser.evaluate("document.body.innerText").count(verdict) == 1, "the verdict is said once"
    traces = browser.evaluate("document.querySelector('[data-chart=landscape]').data.map((t) => [t.type, t.coloraxis || '', t.name || '', (t.x || []).length])")
    assert sum(t[0] == "contour" and t[1] == "coloraxis" for t in traces) == 3, f"three pairs of three parameters: {traces}"
    shown = browser.evaluate("""document.querySelector('[data-chart=landscape]').data.filter((t) => t.type === 'scatter' && t.mode === 'lines' && t.x.length > 50)
    .map((t) => [Math.min(...t.x), Math.max(...t.x), Math.min(...t.y)])""")
    assert len(shown) == 3 and all(abs(s[0] / p["min"] - 1) < 1e-6 and abs(s[1] / p["max"] - 1) < 1e-6 for s, p in zip(shown, unique["parameters"])), \
        f"a profile of each over its range: {shown}"
    assert len(unique["minima"]) > 1 or browser.evaluate("document.querySelector('[data-chart=passes]')") is None, "no passes of one minimum"


def test_the_page_of_sample(browser):
    out = reported("sample")
    sample = json.loads((out / "sample.json").read_text())
    browser.open((out / "report.html").as_uri())
    cells = browser.evaluate("[...document.querySelectorAll('table')].map((t) => [...t.querySelectorAll('tr')].map((r) => [...r.children].map((c) => c.textContent)))")
    marginals = next(t for t in cells if "R-hat" in t[0])
    for quantity in sample["parameters"] + sample["outputs"]:
        assert any(abs(float(row[1]) / quantity["mean"] - 1) < 1e-3 and abs(float(row[5]) / quantity["q975"] - 1) < 1e-3 for row in marginals[1:]), \
            f"{quantity['name']}: {marginals}"
    counts = browser.evaluate("document.querySelector('[data-chart=corner]').data.filter((t) => t.mode === 'markers').map((t) => t.x.length)")
    assert counts == [len(sample["draws"])] * 3, f"every pair of three parameters holds all draws: {counts}"


STATIONS, GAP, WEAK = 400, 250, (36, 201, 330)
LAYERS = (("asphalt", 170, 1200), ("base", 575, 200), ("subgrade", 4255, 60))


def layered(layers):
    """A study of linear layers under a plate, whose moduli are sought."""
    text = 'schema = 1\n[section]\nbottom = "half-space"\n'
    for name, thickness, modulus in layers:
        text += (f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\ndensity_kg_m3 = 2000\nk0 = 0.5\nlaw = "linear"\n'
                 f'modulus_MPa = {modulus}\npoisson = 0.4\n[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {modulus / 6}\nmax = {modulus * 6}\nscale = "log"\n')
    return text + '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 566\n[data]\nmisfit = "relative"\n'


@pytest.fixture(scope="module")
def long_road():
    """A survey of eight stations with positions and three fitted layers, its stations repeated to 400, of which three are weak."""
    bowls = ("473.5,309.5,209.8,158.3,126.4,104.1,87.6", "481.2,312.0,211.1,159.0,126.9,104.4,87.8")
    survey = folder / "long.csv"
    survey.write_text("station,lane,chainage_m,radius_mm,load_kN,D0_um,D300_um,D600_um,D900_um,D1200_um,D1500_um,D1800_um,latitude,longitude,asphalt_C\n" +
                      "".join(f"L{k},L,{25 * k},150,40,{bowls[k % 2]},52.1,5.3,{18 + k}\n" for k in range(8)))
    (folder / "long.toml").write_text(layered(LAYERS))
    out = folder / "long"
    assert run("survey", survey, "--study", folder / "long.toml", "--reference-temperature", 20, "--out", out).returncode == 0, "survey"
    result = json.loads((out / "survey.json").read_text())
    eight = result["stations"]
    result["stations"] = []
    for i in range(STATIONS):
        s = json.loads(json.dumps(eight[i % 8]))
        s.update(station=f"P{i:03}", chainage_m=25.0 * i + (5000 if i >= GAP else 0), latitude=52.1 + 2e-4 * i, longitude=5.3 + 1e-4 * i)
        s["D0_um_at_common_pressure"] *= 2.5 if i in WEAK else 1
        result["stations"].append(s)
    result["counts"]["stations"] = result["counts"]["fitted"] = STATIONS
    result["weak_stations"] = [{"station": i, "times_median": 2.5, "parameter": None, "parameter_times_median": None} for i in WEAK]
    result["sections"] = [{**p, "from_m": 0.0, "to_m": 1e6} for p in result["sections"][:1]]
    (out / "survey.json").write_text(json.dumps(result))
    assert run("report", out).returncode == 0, "report"
    return out / "report.html"


def test_a_road_of_400_stations_is_light(long_road):
    assert long_road.stat().st_size <= 3e6, f"at most 3 MB: {long_road.stat().st_size / 1e6:.2f}"


@pytest.mark.parametrize("width", (1400, 420))
def test_the_first_screen_of_a_long_road(browser, long_road, width):
    browser.resize(width, 900)
    browser.open(long_road.as_uri())
    assert browser.wait("document.querySelector('[data-chart=map] svg.main-svg') !== null", 60), "the map is drawn"
    screens = browser.evaluate("document.documentElement.scrollHeight / window.innerHeight")
    assert screens <= 20, f"at most 20 screens: {screens}"
    place = "(q) => { const r = document.querySelector(q).getBoundingClientRect(); return [r.top, r.bottom]; }"
    verdict, named, map_ = (browser.evaluate(f"({place})('{q}')") for q in ("#summary .verdict", "#summary .named", "#summary [data-chart=map]"))
    assert verdict[1] < named[0] + 1 and named[1] < 900, f"verdict and weak stations: {verdict}, {named}"
    assert map_[0] + 0.75 * (map_[1] - map_[0]) < 900, f"three quarters of the map at least: {map_}"
    text = browser.evaluate("document.querySelector('#summary .named').textContent").replace("\u00a0", " ")
    assert sorted(re.findall(r"P\d+ \(\d+ m\)", text)) == ["P036 (900 m)", "P201 (5025 m)", "P330 (13250 m)"], f"weak stations by chainage: {text}"


def test_strips_and_bowls_of_a_long_road(browser, long_road):
    browser.resize(1400, 900)
    browser.open(long_road.as_uri())
    assert browser.wait("document.querySelector('[data-chart=strip] svg.main-svg') !== null", 60), "a strip is drawn"
    strip = browser.evaluate("(() => { const t = document.querySelector('[data-chart=strip]').data[0]; return { x: t.x, colours: t.marker.color, connect: t.connectgaps }; })()")
    holes = [i for i, x in enumerate(strip["x"]) if x is None]
    assert holes == [GAP] and strip["connect"] is False, f"no line across the gap of 5 km: {holes}"
    at = {x: c for x, c in zip(strip["x"], strip["colours"])}
    assert at[900] != at[875] and len({at[900], at[5025], at[13250]}) == 1, "weak stations have a colour of their own"
    titles = browser.evaluate("[...document.querySelectorAll('[data-chart=strip]')].map((c) => c.layout.yaxis.title.text)")
    assert {"asphalt [°C]", "SCI [µm]", "BDI [µm]"} <= set(titles), f"strips of temperature and indices: {titles}"
    rows = browser.evaluate("[...document.querySelectorAll('details')].find((d) => d.textContent.startsWith('Residuals of the sensors')).querySelector('table').rows.length")
    assert rows == 1 + 7, f"a row of residuals for every sensor: {rows}"
    assert browser.evaluate("['residual-strip', 'surface-modulus'].map((c) => document.querySelectorAll(`[data-chart=${c}]`).length)") == [1, 1], "residuals and surface modulus"
    browser.evaluate("document.querySelector('[data-chart=map]').emit('plotly_click', { points: [{ customdata: 201 }] })")
    assert browser.wait("document.querySelector('[data-chart=bowl] svg.main-svg') !== null", 20), "a click on a station shows its bowl"
    assert "P201" in browser.evaluate("document.querySelector('[data-chart=bowl]').layout.title.text")


def test_the_page_of_design(browser):
    out = reported("design")
    design = json.loads((out / "design.json").read_text())
    browser.open((out / "report.html").as_uri())
    assert browser.wait("document.querySelector('[data-chart=lives] svg.main-svg') !== null", 60), "the lives are drawn"
    assert design["findings"][0] in browser.evaluate("document.querySelector('#summary .verdict').textContent")
    best = browser.evaluate("document.querySelector('[data-chart=lives]').data.find((t) => t.name === 'best').x")
    wanted = [min(200, max(0.1, c["remaining_years"])) for c in design["criteria"] if c["remaining_years"] is not None]
    assert best == pytest.approx(wanted), "the years of each criterion, as far as the axis goes"


def test_what_is_drawn_first_is_not_folded_away(browser):
    for name, chart in (("sensitivity", "curves"), ("map", "pair"), ("compare", "measured"), ("sample", "corner")):
        browser.open((reported(name) / "report.html").as_uri())
        assert browser.wait(f"document.querySelector('[data-chart={chart}] svg.main-svg') !== null", 60), name
        assert browser.evaluate(f"[null, true].includes(((document.querySelector('[data-chart={chart}]').closest('details')) || {{ open: null }}).open)"), f"{name}: its {chart} stand open"


@pytest.mark.long
def test_studies_are_compared_by_short_names(browser):
    other = folder / "the-same-but-rigid.toml"
    other.write_text(linear.read_text().replace('bottom = "half-space"', 'bottom = "rigid"').replace('name = "subgrade"\n', 'name = "subgrade"\nthickness_mm = 3000\n', 1))
    out = folder / "studies"
    done = run("compare", linear, other, "--explore", 16, "--verify", 3, "--out", out)
    assert done.returncode == 0 and run("report", out).returncode == 0, done.stderr
    browser.resize(420, 900)
    browser.open((out / "report.html").as_uri())
    assert browser.wait("document.querySelector('#summary [data-chart=measured] svg.main-svg') !== null", 60), "measured and modelled stand beside the verdict"
    # Wide enough for a telephone, for no path stands in a table.
    assert browser.evaluate("[...document.querySelectorAll('th')].map((h) => h.textContent)").count("the-same-but-rigid") >= 1
    assert browser.evaluate("[...document.querySelectorAll('.wide')].filter((t) => t.scrollWidth > t.clientWidth + 1).length") == 0


def test_the_page_of_a_road_as_one_experiment(browser):
    out = folder / "together"
    study = folder / "together.toml"
    study.write_text(re.sub(r'name = "asphalt.modulus_MPa"\n', 'name = "asphalt.modulus_MPa"\nlevel = "shared"\n', layered(LAYERS)))
    done = run("road", ROOT / "grids" / "road-example.csv", "--study", study, "--out", out)
    assert done.returncode == 0 and run("report", out).returncode == 0, done.stderr
    road = json.loads((out / "road.json").read_text())
    browser.resize(1400, 900)
    browser.open((out / "report.html").as_uri())
    assert browser.wait("document.querySelector('#summary [data-chart=strip] svg.main-svg') !== null", 60)
    assert "as one experiment" in road["answer"] and "as one experiment" in browser.evaluate("document.querySelector('#summary .verdict').textContent")
    rows = browser.evaluate("[...document.querySelectorAll('#summary tbody tr')].map((r) => r.children[0].textContent)")
    assert rows == ["asphalt modulus"], f"what the stations have in common: {rows}"
    titles = browser.evaluate("[...document.querySelectorAll('[data-chart=strip]')].map((c) => c.layout.yaxis.title.text)")
    assert "base modulus [MPa]" in titles and "asphalt modulus [MPa]" not in titles, f"no strip of what is alike everywhere: {titles}"
