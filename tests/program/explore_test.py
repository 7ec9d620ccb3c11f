"""`explore`: nobody but the page of this machine is answered; what it answers is what `forward` computes; in headless Chromium a slider
moves the curve, a reading the minimum, and the full model confirms."""
import http.client
import re
import signal
import socket
import urllib.parse

import pytest

from browser import CHROMIUM, Browser
from support import *

folder = workspace()
study = write_study(folder / "s")
running = []


def serve(*options):
    """The started program; its port and token."""
    process = subprocess.Popen([PROGRAM, "explore", str(study), "--out", str(folder / "out"), *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    running.append(process)
    line = process.stdout.readline()
    found = re.fullmatch(r"open http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]{32})\n", line)
    assert found is not None, f"an address with a token: {line}{process.stderr.read() if not line else ''}"
    return process, int(found.group(1)), found.group(2)


def get(port, path, host=None, headers={}, address="127.0.0.1"):
    """(status, body) of a request as it is given."""
    connection = http.client.HTTPConnection(address, port, timeout=60)
    connection.putrequest("GET", path, skip_host=True)
    for name, value in {"Host": f"127.0.0.1:{port}" if host is None else host, **headers}.items():
        if value != "":
            connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, answer.read().decode(), dict(answer.getheaders())


@pytest.fixture(scope="module")
def server():
    yield serve()
    for process in running:
        process.kill()
        process.wait()


def test_nobody_but_the_page_of_this_machine_is_answered(server):
    _, port, token = server
    ok = f"/state?token={token}"
    status, body, headers = get(port, f"/?token={token}")
    assert status == 200 and "<!DOCTYPE html>" in body and headers["Cache-Control"] == "no-store", f"the page: {status}"
    assert not re.search(r'(src|href)="(?!data:)', body.split("<script>")[0] + body.rsplit("</script>", 1)[1]), "the page refers to nothing elsewhere"
    assert get(port, ok)[0] == 200 and get(port, ok, host=f"localhost:{port}")[0] == 200, "the state, by either name of this machine"
    for path in ("/", "/state", "/evaluate?at=1,1", "/fit?at=1,1", "/landscape?at=1,1", "/confirm?at=1,1", "/nothing"):
        for token_part in ("", "token=", "token=" + "0" * 32, f"token={token[:-1]}", f"token={token}0", f"token={token}&token=0", f"token=0&token={token}"):
            status, body, _ = get(port, path + ("&" if "?" in path else "?") + token_part)
            assert status == 403 and body == "", f"{path} with \"{token_part}\": {status} {body[:80]}"
    for host in ("", "example.org", f"example.org:{port}", "127.0.0.1", f"127.0.0.1:{port + 1}", f"127.0.0.1.example.org:{port}", f"[::1]:{port}"):
        assert get(port, ok, host=host)[0] in (400, 403), f"host \"{host}\" is refused"
    for origin in (f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
        assert get(port, ok, headers={"Origin": origin})[0] == 200, f"origin {origin} is answered"
    for origin in ("http://example.org", "null", f"https://127.0.0.1:{port}", f"http://127.0.0.1:{port + 1}", f"http://127.0.0.1:{port}.example.org"):
        assert get(port, ok, headers={"Origin": origin})[0] == 403, f"origin {origin} is refused"
    others = {"127.0.0.2", *(a[4][0] for a in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET))} - {"127.0.0.1"}
    for address in others:
        try:
            socket.create_connection((address, port), timeout=5).close()
            assert False, f"something listens on {address}"
        except OSError:
            pass


@pytest.fixture(scope="module")
def state(server):
    _, port, token = server
    # What is answered.
    return json.loads(get(port, f"/state?token={token}")[1])


def test_the_state_has_readings_and_outputs(state):
    assert [p["name"] for p in state["parameters"]] == ["base.k1", "base.n"] and state["model"] == "reduced", f"the state: {state['model']}"
    assert state["readings"][0]["measured"] == 0.95 and state["outputs"][0]["name"] == "subgrade-top-strain", "readings and outputs"


def ask(server, what, **parameters):
    _, port, token = server
    status, body, _ = get(port, f"/{what}?{urllib.parse.urlencode({**parameters, 'token': token})}")
    assert status == 200, f"{what} {parameters}: {status} {body[:200]}"
    return json.loads(body)


def forward(k1, n):
    text = STUDY.replace("k1 = 2000", f"k1 = {k1!r}").replace("n = 0.5\n", f"n = {n!r}\n")
    return [r["value"] for r in json.loads(run("forward", write_study(folder / "f", text), "--json").stdout)["responses"]]


def test_what_is_answered_is_what_forward_computes(server, state):
    stated = max(float(v) for v in re.findall(r"within ([\d.]+) %", state["model_words"])) / 100
    within = []
    for k1, n in ((700.0, 0.2), (1500.0, 0.5), (2500.0, 1.0), (4000.0, 0.3), (6000.0, 2.0)):
        found = ask(server, "evaluate", at=f"{k1},{n}")
        full = forward(k1, n)
        off = [abs(a / b - 1) for a, b in zip(found["values"] + found["outputs"], full)]
        assert max(off) < 0.03, f"at {k1}, {n} every reading is within the error at which the full model steps in: {off}"
        within += [v <= stated for v in off]
        confirmed = ask(server, "confirm", at=f"{k1},{n}")
        assert max(abs(a / b - 1) for a, b in zip(confirmed["values"] + confirmed["outputs"], full)) < 1e-12, "the full model confirms what forward computes"
    assert sum(within) >= 0.8 * len(within), f"readings within the stated error of {stated}: {sum(within)} of {len(within)}"


def test_readings_of_the_model_are_met_where_it_reads_them(server):
    # Readings that are what the model reads somewhere are met there.
    exact = forward(2500.0, 1.0)
    changed = ",".join(f"{i}:{v!r}" for i, v in enumerate(exact[:4]))
    found = ask(server, "fit", at="2000,0.8", changed=changed)
    assert abs(found["minimum"]["at"][0] / 2500 - 1) < 0.1 and abs(found["minimum"]["at"][1] - 1.0) < 0.15, f"the minimum moves there: {found['minimum']['at']}"


def test_a_landscape_is_the_points_there(server):
    grid = ask(server, "landscape", at="2000,0.8", x=0, y=1, lines=5, fitted=0)
    assert len(grid["chi2"]) == 5 and grid["x_values"][0] == 500 and grid["y_values"][-1] == 4.5, "a grid over the box"
    node = ask(server, "evaluate", at=f"{grid['x_values'][2]!r},{grid['y_values'][1]!r}")
    assert abs(grid["chi2"][1][2] / node["chi2"] - 1) < 1e-9, "a node is the point there"


def test_wrong_questions_are_refused(server):
    _, port, token = server
    for wrong in ("at=1", "at=", "at=1,x", "at=nan,1", "at=1,1&changed=9:1", "at=1,1&changed=1", "at=1,1&changed=0:inf"):
        status, body, _ = get(port, f"/evaluate?{wrong}&token={token}")
        assert status == 400 and "error" in json.loads(body), f"{wrong}: {status} {body[:100]}"
    assert get(port, f"/landscape?at=1,1&x=1&y=1&lines=5&fitted=0&token={token}")[0] == 400, "one parameter is no pair"


def test_what_cannot_be_explored_is_said(server):
    _, port, _ = server
    done = run("explore", study, "--out", folder / "out", "--port", port)
    assert done.returncode == 2 and done.stdout == "" and "--port" in done.stderr, f"a port that is taken: {done.stderr}"
    done = run("explore", ROOT / "grids" / "layered-bowl.toml")
    assert done.returncode == 2 and done.stdout == "" and "measurements" in done.stderr, f"a study without readings: {done.stderr}"


def test_the_page_in_a_browser(server):
    _, port, token = server
    if CHROMIUM is None:
        assert False, "chromium is needed to open the page"
    else:
        browser = Browser(folder / "profile")
        browser.open(f"http://127.0.0.1:{port}/?token={token}")
        assert browser.wait("document.documentElement.dataset.updates > 0"), "the page draws itself"
        model = "document.querySelector('[data-chart=readings]').data.find((t) => t.name === 'model').y.filter((v) => v !== null)"
        updates = "Number(document.documentElement.dataset.updates)"
        before = browser.evaluate(model)
        number = browser.evaluate(updates)
        browser.evaluate("document.getElementById('p0').focus()")
        browser.key("ArrowRight")
        browser.key("ArrowRight")
        assert browser.wait(f"{updates} > {number}", 10), "a key on a slider asks the model"
        browser.wait(f"JSON.stringify({model}) !== {json.dumps(json.dumps(before))}", 10)
        after = browser.evaluate(model)
        assert len(after) == len(before) and after != before, "the curve moves with the slider"
        number, begin = browser.evaluate(updates), time.monotonic()
        browser.evaluate("""new Promise((done) => { const slider = document.getElementById("p0"); let k = 0;
        const step = () => { slider.value = String(200 + 2 * k); slider.dispatchEvent(new Event("input")); if (++k < 200) setTimeout(step, 10); else done(); }; step(); })""")
        seconds = time.monotonic() - begin
        drawn = browser.evaluate(updates) - number
        assert drawn > 5, f"the page follows a drag: {drawn} updates"
        print(f"{drawn / seconds:.0f} updates a second while a slider is dragged")
        # What was moved over the old axes is what is drawn anew.
        time.sleep(0.5)
        moved, anew = browser.evaluate("""(async () => { const chart = document.querySelector("[data-chart=readings]");
        const lines = () => [...chart.querySelectorAll(".scatterlayer path")].map((p) => p.getAttribute("d") + p.getAttribute("transform")).join("; ");
        const moved = lines(); await Plotly.redraw(chart); return [moved, lines()]; })()""")
        assert moved == anew and len(moved) > 100, f"the moved chart: {moved[:300]} and drawn anew: {anew[:300]}"
        # The mark over the landscape stands where the sliders do, whatever the size of the window.
        marked = """(() => { const { xaxis } = document.querySelector('[data-chart=landscape]')._fullLayout;
        return xaxis.p2d(parseFloat(document.querySelector('.here').style.left) - xaxis._offset) / Number(document.querySelector('.slider input[type=number]').value); })()"""
        assert browser.wait("!!document.querySelector('[data-chart=landscape]')._fullLayout", 20), "the landscape is drawn"
        for width in (1400, 400, 1400):
            browser.resize(width, 1000)
            assert browser.wait(f"Math.abs({marked} - 1) < 0.01", 10), f"the mark at {width} px: {browser.evaluate(marked)}"
        browser.evaluate("document.querySelectorAll('tr.reading button')[1].click()")
        assert browser.wait("document.body.innerText.includes('How the minimum moves')", 20), "5 % more of a reading moves the minimum"
        assert browser.wait("document.querySelectorAll('tr.changed').length === 1", 10), "the reading is marked"
        # A measured point is dragged.
        browser.evaluate("[...document.querySelectorAll('button')].find((b) => b.textContent === 'all as measured').click()")
        browser.wait("!document.body.innerText.includes('How the minimum moves')", 20)
        at = browser.evaluate("""(() => { const c = document.querySelector("[data-chart=readings]"); c.scrollIntoView(); const b = c.getBoundingClientRect(); const l = c._fullLayout;
        return [b.left + l.xaxis._offset + l.xaxis.d2p(0), b.top + l.yaxis._offset + l.yaxis.d2p(0.95)]; })()""")
        browser.mouse("mouseMoved", *at)
        browser.mouse("mousePressed", *at, buttons=1)
        for step in range(1, 5):
            browser.mouse("mouseMoved", at[0], at[1] + 5 * step, buttons=1)
        browser.mouse("mouseReleased", at[0], at[1] + 20)
        assert browser.wait("document.querySelectorAll('tr.changed').length === 1", 20), "a point is dragged"
        assert browser.evaluate("Number(document.querySelector('tr.changed input').value)") > 0.96, "to a larger deflection"
        browser.evaluate("document.querySelector('button.main').click()")
        assert browser.wait("document.body.innerText.includes('Full model: χ²')", 60), "the full model confirms"
        for width in (1400, 400):
            browser.resize(width, 900)
            time.sleep(0.5)
            assert browser.evaluate("document.documentElement.scrollWidth <= document.documentElement.clientWidth"), f"no wider than {width} px"
        assert browser.evaluate("document.documentElement.dataset.failures") is None and browser.console == [], f"nothing on the console: {browser.console}"
        browser.close()


def test_signals_end_it_and_the_token_is_another_the_next_time(server):
    process, port, token = server
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0, f"Ctrl-C ends it: {process.returncode}"
    process, port, again = serve("--port", str(port))
    assert again != token, "another token the next time"
    process.send_signal(signal.SIGTERM)
    assert process.wait(20) == 0, "so does SIGTERM"
