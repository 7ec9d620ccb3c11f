"""Models of your own: programs and UM-Bridge servers as forward functions, `serve`, what goes wrong with them."""
import http.server
import math
import signal
import sys
import threading
import urllib.error
import urllib.request

from support import *

PYTHON = ["/usr/bin/python3", "-I", "-S"]

ROSENBROCK = """
import json
x, y = (float(line) for line in open("in.txt"))
json.dump({"readings": [10 * (y - x * x), 1 - x]}, open("out.json", "w"))
"""


def study_of(folder, model, parameters, readings, data='misfit = "weighted"', more=""):
    """A study file with its measurements: parameters (name, min, max, further keys), readings (name, value, sigma)."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "data.csv").write_text("name,value,sigma\n" + "".join(f"{n},{v},{s}\n" for n, v, s in readings))
    text = f'schema = 1\n[model]\n{model}\n[data]\nfiles = ["data.csv"]\n{data}\n'
    for name, low, high, *keys in parameters:
        text += f'[[parameters]]\nname = "{name}"\nmin = {low}\nmax = {high}\n' + "".join(key + "\n" for key in keys)
    (folder / "study.toml").write_text(text + more)
    return folder / "study.toml"


def program_study(folder, script, parameters, readings, template=None, outputs='{ file = "out.json", at = "/readings" }', keys="", **more):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "model.py").write_text(script)
    (folder / "in.tmpl").write_text(template or "".join("{{%s}}\n" % p[0] for p in parameters))
    command = ", ".join(f'"{word}"' for word in [*PYTHON, "model.py"])
    model = (f'type = "program"\ncommand = [{command}]\ninputs = [{{ template = "in.tmpl", file = "in.txt" }}]\n'
             f'files = ["model.py"]\noutputs = [{outputs}]\n{keys}')
    return study_of(folder, model, parameters, readings, **more)


def rosenbrock(folder, script=ROSENBROCK, **more):
    # The sum of squares is Rosenbrock's function: 0 at (1, 1) and nowhere else.
    return program_study(folder, script, [("x", -2, 2, "value = -1.2"), ("y", -1, 3, "value = 1.0")], [("valley", 0, 1), ("slope", 0, 1)], **more)


def test_fit_of_a_program_finds_the_minimum_of_rosenbrock():
    folder = workspace()
    done = run("fit", rosenbrock(folder), "--explore", 16, "--starts", 3, "--joint-only", "--json", "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    best = found["best"]
    assert abs(best["parameters"]["x"] - 1) < 1e-4 and abs(best["parameters"]["y"] - 1) < 2e-4, best
    assert best["misfit"] < 1e-3
    assert any(text.startswith("Derivatives are by one-sided differences") for text in found["findings"]), found["findings"]
    assert not (folder / "out" / "runs").exists(), "no run failed, none is kept"


def test_forward_of_a_program_and_its_derivatives():
    folder = workspace()
    study = rosenbrock(folder, more='[[outputs]]\nname = "sum"\nunit = "V"\n', script=ROSENBROCK.replace("1 - x]", "1 - x, x + y]"))
    done = run("forward", study, "--json", "--jacobian")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    # At (-1.2, 1): 10 (1 - 1.44) and 2.2; derivatives -20 x, 10; -1, 0.
    assert [round(r["value"], 12) for r in answer["responses"]] == [-4.4, 2.2, -0.2]
    assert [r["name"] for r in answer["responses"]] == ["valley", "slope", "sum"] and answer["responses"][2]["unit"] == "V"
    wanted = [[24, 10], [-1, 0], [1, 1]]
    for row, exact in zip(answer["jacobian"]["rows"], wanted):
        assert all(abs(a - b) < 1e-5 for a, b in zip(row, exact)), (row, exact)
    set_to = json.loads(run("forward", study, "--json", "--set", "x=1", "--set", "y=1").stdout)
    assert [r["value"] for r in set_to["responses"]] == [0, 0, 2]


def test_a_study_in_the_folder_where_one_stands():
    folder = workspace()
    rosenbrock(folder)
    done = run("forward", "study.toml", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert [round(r["value"], 12) for r in json.loads(done.stdout)["responses"]] == [-4.4, 2.2]


def test_kill_and_continue():
    folder = workspace()
    study = rosenbrock(folder)
    asked = ("fit", study, "--explore", 24, "--starts", 2, "--joint-only")
    whole = run(*asked, "--out", folder / "whole")
    assert whole.returncode == 0, whole.stderr
    killed = kill_at(8, folder / "cut", *asked)
    assert 8 <= killed < evaluations(folder / "whole"), killed
    again = run(*asked, "--out", folder / "cut", "--threads", 1)
    assert again.returncode == 0, again.stderr
    assert result(folder / "cut", "fit") == result(folder / "whole", "fit"), "the same bits, whatever was interrupted"
    assert counted(folder / "cut")[1] < counted(folder / "cut")[0] + 24, "what was stored is not run again"


@pytest.mark.parametrize("script, keys, words", [
    ('import sys\nsys.stderr.write("first\\nno steel left\\n")\nsys.exit(3)', "", "ended with status 3: first | no steel left"),
    ("pass", "", "the program wrote no out.json"),
    ('open("out.json", "w").write(\'{"readings": [1]}\')', "", "is a list of 1, where a list of 2 readings is wanted"),
    ('open("out.json", "w").write(\'{"readings": [1, NaN]}\')', "", "not valid JSON"),
    ("import time\ntime.sleep(60)", "time_limit_s = 0.5", "ran longer than time_limit_s = 0.5 and was ended"),
    ("import os\nos.kill(os.getpid(), 11)", "", "was ended by signal 11"),
], ids=["status", "no file", "too few", "NaN", "hangs", "signal"])
def test_a_run_without_an_answer_says_why(script, keys, words):
    folder = workspace()
    done = run("forward", rosenbrock(folder, script=script, keys=keys))
    assert done.returncode == 1 and words in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_a_model_that_never_answers_is_said_at_once():
    folder = workspace()
    study = rosenbrock(folder, script="import sys\nsys.exit('no licence')")
    done = run("fit", study, "--explore", 24, "--out", folder / "out")
    first, last = done.stderr.strip().splitlines()
    assert done.returncode == 1 and "no answer at the first 10 points; one says: " in first and "no licence" in first, done.stderr
    assert "not one explored point has an answer" in last, done.stderr
    done = run("unique", study, "--model", "auto", "--out", folder / "auto")
    assert done.returncode == 1 and "too few for a stand-in" in done.stderr.splitlines()[-1] and "no licence" in done.stderr.splitlines()[-1], done.stderr


def test_failed_points_are_holes_and_their_folders_stay():
    folder = workspace()
    script = ROSENBROCK.replace("json.dump", "assert x < 1.5, 'x is too large'\njson.dump", 1)
    done = run("map", rosenbrock(folder, script=script, keys='keep = "failed"'), "--design", "grid", "--points", 5, "--json", "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert (answer["statuses"]["converged"], answer["statuses"]["failed"]) == (20, 5), answer["statuses"]
    database = sqlite3.connect(folder / "out" / "run.sqlite")
    reasons = [row[0] for row in database.execute("SELECT reason FROM evaluation WHERE reason != ''")]
    assert len(reasons) == 5 and all("x is too large" in reason for reason in reasons), reasons
    kept = sorted(p.name for p in (folder / "out" / "runs").iterdir())
    assert len(kept) == 5 and all(name.startswith("failed-") for name in kept), kept
    assert "x is too large" in (folder / "out" / "runs" / kept[0] / "stderr.txt").read_text()


def test_runs_over_time_are_tried_again():
    folder = workspace()
    flag = folder / "ready"
    script = f"import os, time\nif not os.path.exists({str(flag)!r}): time.sleep(60)\n" + ROSENBROCK
    study = rosenbrock(folder, script=script, keys="time_limit_s = 10")
    asked = ("map", study, "--design", "grid", "--points", 2, "--json", "--out", folder / "out", "--threads", 2)
    first = run(*asked)
    assert first.returncode == 1 and "ran longer than" in first.stderr, first.stderr
    assert evaluations(folder / "out") == 0, "nothing of that is kept"
    flag.write_text("")
    second = run(*asked)
    assert second.returncode == 0, second.stderr


BAD = [
    ("unknown key", lambda s: s.replace("files =", "filez =", 1), "study.toml:6", "unknown key, did you mean \"files\"?"),
    ("layers", lambda s: s + '[[layers]]\nname = "a"\n', "layers", "belongs to the built-in model"),
    ("no command", lambda s: s.replace("command = [", "command = []#", 1), "command", "the command is empty"),
    ("type", lambda s: s.replace('type = "program"', 'type = "progam"'), "type", "did you mean \"program\"?"),
    ("reading", lambda s: s.replace('at = "/readings"', 'at = "/readings", reading = "vally"'), "reading", "did you mean \"valley\"?"),
    ("place", lambda s: s.replace('at = "/readings"', 'by = ["x"]'), "by", "readings are not told apart by this"),
    ("line", lambda s: s.replace('at = "/readings"', 'reading = "valley", line = "behind"'), "line", "this says no line"),
    ("template", lambda s: s.replace("in.tmpl", "none.tmpl"), "template", "this template does not exist"),
    ("outside", lambda s: s.replace('files = ["model.py"]', 'files = ["../model.py"]'), "files", "outside the model's folder"),
    ("equals", lambda s: s + '[[parameters]]\nname = "z"\nequals = "x"\n', "equals", ""),
    ("no place", lambda s: s + '[[parameters]]\nname = "z"\nmin = 0\nmax = 1\n', "inputs", "no template has a place for this parameter"),
]


@pytest.mark.parametrize("change, place, words", [row[1:] for row in BAD], ids=[row[0] for row in BAD])
def test_bad_studies(change, place, words):
    folder = workspace()
    study = rosenbrock(folder)
    study.write_text(change(study.read_text()))
    done = run("check", study)
    assert done.returncode == 2 and place in done.stderr and words in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr


def test_a_bad_template_is_named():
    folder = workspace()
    study = rosenbrock(folder, template="{{x}}\n{{yy}}\n")
    done = run("check", study)
    assert done.returncode == 2 and "in.tmpl:2" in done.stderr and "did you mean \"y\"?" in done.stderr, done.stderr


@pytest.mark.parametrize("command", ["explore", "compare"])
def test_what_knows_the_built_in_model_alone_says_so(command):
    folder = workspace()
    done = run(command, rosenbrock(folder), cwd=folder)
    assert done.returncode == 2 and "knows the built-in model alone" in done.stderr, done.stderr


# --- UM-Bridge: an implementation of the protocol of the tests' own


class Model:
    """y_i = exp(-k1 t_i) + exp(-k2 t_i), one output vector."""
    times = [0.25 * (i + 1) for i in range(12)]
    inputs = 2

    def __call__(self, k):
        return [math.exp(-k[0] * t) + math.exp(-k[1] * t) for t in self.times]

    def column(self, k, vec):
        return [-t * math.exp(-k[0] * t) * vec[0] - t * math.exp(-k[1] * t) * vec[1] for t in self.times]


def serve(model, offers=("Evaluate",), port=0, name="decay"):
    """(address, list of paths requested, server)"""
    asked = []

    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        disable_nagle_algorithm = True  # as servers of the protocol do

        def log_message(self, *_):
            pass

        def answer(self, body, status=200):
            data = json.dumps(body).encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)

        def do_GET(self):
            self.answer({"protocolVersion": 1.0, "models": [name]})

        def do_POST(self):
            request = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            asked.append(self.path)
            if request["name"] != name:
                self.answer({"error": {"type": "ModelNotFound", "message": "no"}}, 400)
            elif self.path == "/ModelInfo":
                self.answer({"support": {name: name in offers for name in ("Evaluate", "Gradient", "ApplyJacobian", "ApplyHessian")}})
            elif self.path == "/InputSizes":
                self.answer({"inputSizes": [1] * model.inputs})
            elif self.path == "/OutputSizes":
                self.answer({"outputSizes": [len(model.times)]})
            elif self.path == "/Evaluate":
                k = [v[0] for v in request["input"]]
                if request["config"].get("limit", math.inf) < max(k):
                    self.answer({"error": {"type": "InvalidInput", "message": "too fast"}}, 400)
                else:
                    self.answer({"output": [model(k)]})
            elif self.path == "/ApplyJacobian":
                k = [v[0] for v in request["input"]]
                vec = [0.0, 0.0]
                vec[request["inWrt"]] = request["vec"][0]
                self.answer({"output": model.column(k, vec)})

    server = http.server.ThreadingHTTPServer(("127.0.0.1", port), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_port}", asked, server


def decay(folder, url, ranges=((0.1, 4), (0.1, 4)), truth=(0.4, 1.6), keys=""):
    # Exact readings: the minimum is the truth.
    readings = [(f"y{i}", repr(y), 0.01) for i, y in enumerate(Model()(truth))]
    parameters = [(f"k{i + 1}", low, high, 'scale = "log"') for i, (low, high) in enumerate(ranges)]
    return study_of(folder, f'type = "um-bridge"\nurl = "{url}"\nname = "decay"\n{keys}', parameters, readings)


def test_exchanged_solutions_of_a_server_are_two():
    folder = workspace()
    url, asked, server = serve(Model(), ("Evaluate", "ApplyJacobian"))
    done = run("unique", decay(folder, url), "--json", "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["verdict"] == "non-unique", answer["verdict"]
    ends = sorted((m["parameters"]["k1"], m["parameters"]["k2"]) for m in answer["minima"] if m["misfit"] < 1e-3)
    assert len(ends) == 2, answer["minima"]
    for found, exact in zip(ends, [(0.4, 1.6), (1.6, 0.4)]):
        assert all(abs(a / b - 1) < 1e-4 for a, b in zip(found, exact)), ends
    assert "/ApplyJacobian" in asked and "/Gradient" not in asked, "derivatives come from the server"
    server.shutdown()


def test_one_of_them_alone_is_unique():
    folder = workspace()
    url, asked, server = serve(Model())
    done = run("unique", decay(folder, url, ((0.1, 0.8), (0.9, 4))), "--json", "--out", folder / "out")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["verdict"] == "unique", answer["verdict"]
    # The ranges of the linear analysis: sigma sqrt((J'J)^-1), nearly normal here.
    j = [[-t * math.exp(-k * t) / 0.01 for k in (0.4, 1.6)] for t in Model.times]
    a, b, c = (sum(row[p] * row[q] for row in j) for p, q in ((0, 0), (0, 1), (1, 1)))
    best = answer["minima"][0]["parameters"]
    for parameter, variance, value in zip(answer["profiles"], (c / (a * c - b * b), a / (a * c - b * b)), (0.4, 1.6)):
        half = 1.96 * math.sqrt(variance)
        assert abs(best[parameter["name"]] / value - 1) < 1e-3, best
        assert abs((parameter["high"] - parameter["low"]) / (2 * half) - 1) < 0.25, (parameter, half)
    assert any("differences" in text for text in answer["findings"]), "the server offers no derivatives"
    server.shutdown()


class Meyer(Model):
    """Meyer's resistances of a thermistor (More, Garbow and Hillstrom 1981, problem 10): x1 exp(x2 / (45 + 5 i + x3))."""
    times, inputs = range(1, 17), 3
    measured = [34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820, 3307, 2872]

    def __call__(self, x):
        return [x[0] * math.exp(x[1] / (45 + 5 * i + x[2])) for i in self.times]


class Wave(Model):
    """Seven waves of one parameter: every value of it that reads 0.5 on the way up or down."""
    times, inputs = [0, 1], 1

    def __call__(self, x):
        return [math.sin(14 * math.pi * x[0]), 0.0]


class Doses(Model):
    """A sigmoid response to doses that all lie far below its middle: there it is top (dose / middle)^2, to some per mille."""
    times, inputs = [0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4], 2

    def __call__(self, x):
        return [x[0] / (1 + (x[1] / dose) ** 2) for dose in self.times]


class Rosenbrock(Model):
    times, inputs = [0, 1], 2

    def __call__(self, x):
        return [10 * (x[1] - x[0] * x[0]), 1 - x[0]]


def verdict(model, parameters, readings):
    folder = workspace()
    url, _, server = serve(model)
    study = study_of(folder, f'type = "um-bridge"\nurl = "{url}"\nname = "decay"', parameters, readings)
    done = run("unique", study, "--json", "--out", folder / "out", "--threads", 1)
    server.shutdown()
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_ranges_hold_every_minimum_that_is_listed_however_many_there_are():
    answer = verdict(Wave(), [("x", 0, 1)], [("sine", 0.5, 0.02), ("nothing", 0, 1)])
    minima = sorted(m["parameters"]["x"] for m in answer["minima"] if m["misfit"] < 0.1)
    # sin(14 pi x) = 1/2: x = (1/6 + 2 i) / 14 and (5/6 + 2 i) / 14, fourteen of them; beyond the outermost by asin(0.5 +- 1.96 * 0.02).
    assert len(minima) == 14, minima
    high = 2 * 6 / 14 + 1 / 14 - math.asin(0.5 - 1.96 * 0.02) / (14 * math.pi)
    low = math.asin(0.5 - 1.96 * 0.02) / (14 * math.pi)
    (x,) = answer["parameters"]
    assert abs(x["low"] - low) < 2e-4 and abs(x["high"] - high) < 2e-4, (x, low, high)


def test_a_server_that_lacks_the_model_is_asked_again():
    folder = workspace()
    url, _, server = serve(Model())
    study = decay(folder, url)
    study.write_text(study.read_text().replace('name = "decay"', 'name = "decline"'))
    done = run("fit", study, "--explore", 4, "--starts", 1, "--out", folder / "out")
    assert done.returncode != 0 and 'no model "decline"' in done.stdout + done.stderr, done.stdout + done.stderr
    server.shutdown()
    server.server_close()
    again, _, later = serve(Model(), port=server.server_port, name="decline")
    assert again == url
    done = run("fit", study, "--explore", 4, "--starts", 1, "--out", folder / "out")
    later.shutdown()
    assert done.returncode == 0, done.stdout + done.stderr


def test_rosenbrock_in_two_dimensions_is_unique():
    answer = verdict(Rosenbrock(), [("x", -2, 2), ("y", -1, 3)], [("valley", 0, 0.05), ("slope", 0, 0.05)])
    assert answer["verdict"] == "unique", answer["findings"]
    assert answer["minima"][0]["parameters"] == pytest.approx({"x": 1, "y": 1}, abs=1e-3)


def test_meyer_is_unique_where_it_is_known_to_be():
    readings = [(f"r{i + 1}", y, 1) for i, y in enumerate(Meyer.measured)]
    answer = verdict(Meyer(), [("x1", 1e-3, 3e-2, 'scale = "log"'), ("x2", 4000, 8000), ("x3", 200, 500)], readings)
    assert answer["minima"][0]["parameters"] == pytest.approx({"x1": 0.00560964, "x2": 6181.346, "x3": 345.2236}, rel=2e-3)
    assert answer["minima"][0]["misfit"] ** 2 == pytest.approx(87.9458, rel=1e-3), "the sum of squares of the literature"


def test_a_response_to_small_doses_has_a_valley():
    truth = (100.0, 60.0)
    readings = [(f"d{i + 1}", repr(y), 0.02) for i, y in enumerate(Doses()(truth))]
    answer = verdict(Doses(), [("top", 10, 1000, 'scale = "log"'), ("middle", 10, 1000, 'scale = "log"')], readings)
    assert answer["verdict"] == "non-unique", answer["findings"]
    # top / middle^2 alone is known: along the valley one grows as the square of the other.
    assert all(p["high"] / p["low"] > 3 for p in answer["profiles"]), answer["profiles"]


def test_several_servers_share_the_work_and_change_no_bit():
    folder = workspace()
    servers = [serve(Model()) for _ in range(2)]
    one = decay(folder / "one", servers[0][0])
    two = decay(folder / "two", servers[0][0])
    two.write_text(two.read_text().replace(f'url = "{servers[0][0]}"', f'urls = ["{servers[0][0]}", "{servers[1][0]}"]'))
    for study, threads in ((one, 1), (two, 2)):
        done = run("map", study, "--design", "grid", "--points", 12, "--out", study.parent / "out", "--threads", threads)
        assert done.returncode == 0, done.stderr
    assert all(asked.count("/Evaluate") > 0 for _, asked, _ in servers), "both were asked"
    assert result(one.parent / "out", "map")[1] == result(two.parent / "out", "map")[1], "the same points with the same answers"
    # One that is down is said, and what was answered stays.
    servers[1][2].shutdown()
    servers[1][2].server_close()
    down = two.read_text().replace(f'urls = ["{servers[0][0]}", "{servers[1][0]}"]', f'urls = ["{servers[1][0]}"]')
    (two.parent / "down.toml").write_text(down)
    done = run("forward", two.parent / "down.toml")
    assert done.returncode == 1 and f"the server at {servers[1][0]} does not answer" in done.stderr, done.stderr
    servers[0][2].shutdown()


def test_errors_of_servers():
    folder = workspace()
    url, _, server = serve(Model())
    study = decay(folder, url, keys="config = { limit = 0.2 }")
    done = run("forward", study)
    assert done.returncode == 1 and "InvalidInput: too fast" in done.stderr, done.stderr
    text = study.read_text()
    study.write_text(text.replace('name = "decay"', 'name = "growth"'))
    done = run("forward", study)
    assert done.returncode == 1 and 'no model "growth"; it has decay' in done.stderr, done.stderr
    study.write_text(text + '[[outputs]]\nname = "more"\n')
    done = run("forward", study)
    assert done.returncode == 1 and "takes 2 numbers and gives 12; the study has 2 parameters and 13" in done.stderr, done.stderr
    server.shutdown()
    server.server_close()
    study.write_text(text)
    done = run("fit", study, "--explore", 16, "--out", folder / "out")
    assert done.returncode == 1 and "does not answer" in done.stderr, done.stderr
    assert evaluations(folder / "out") == 0, "points that a dead server had no answer for are not kept"
    study.write_text(text.replace(url, "https://127.0.0.1:1"))
    done = run("check", study)
    assert done.returncode == 2 and "this is no address of a server" in done.stderr, done.stderr


# --- serve


class Served:
    def __init__(self, study):
        self.process = subprocess.Popen([PROGRAM, "serve", str(study), "--port", "0", "--threads", "2"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.url = self.process.stdout.readline().split(" at ")[1].strip()

    def ask(self, path, **body):
        request = urllib.request.Request(self.url + path, json.dumps({"name": "forward", **body}).encode() if path != "/Info" else None)
        try:
            return json.loads(urllib.request.urlopen(request, timeout=60).read())
        except urllib.error.HTTPError as error:
            return {"status": error.code, **json.loads(error.read() or "{}")}

    def end(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait(20)


@pytest.fixture(scope="module")
def pavement():
    folder = workspace()
    study = small_study(folder)
    served = Served(study)
    yield folder, study, served
    served.end()


def small_study(folder):
    """A plate on three linear layers, whose readings are those of moduli 3000, 300 and 60 MPa."""
    layer = 'density_kg_m3 = 2000\nk0 = 0.5\nlaw = "linear"\n'
    text = "schema = 1\n"
    for name, thickness, modulus in (("asphalt", 100, 3000), ("base", 300, 300), ("subgrade", 4000, 60)):
        text += f'[[layers]]\nname = "{name}"\nthickness_mm = {thickness}\n{layer}modulus_MPa = {modulus}\npoisson = 0.35\n'
    text += '[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = 150\npressure_kPa = 700\n[data]\nfiles = ["fwd.csv"]\noutside = true\nmisfit = "weighted"\n'
    for name, low, high in (("asphalt", 1000, 9000), ("base", 100, 900), ("subgrade", 20, 180)):
        text += f'[[parameters]]\nname = "{name}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\n'
    text += '[[outputs]]\nname = "strain"\nload = "fwd"\nquantity = "strain_xx"\nx_mm = 0\ndepth_mm = 99\n'
    (folder / "direct.toml").write_text(text)
    rows = "".join(f"fwd,deflection,{x},0,0,0,1,mm,0.002\n" for x in (0, 200, 300, 450, 600, 900, 1200, 1500))
    (folder / "fwd.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + rows)
    values = [r["value"] for r in json.loads(run("forward", folder / "direct.toml", "--json").stdout)["responses"]][:-1]
    rows = "".join(f"fwd,deflection,{x},0,0,0,{v!r},mm,0.002\n" for x, v in zip((0, 200, 300, 450, 600, 900, 1200, 1500), values))
    (folder / "fwd.csv").write_text("load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n" + rows)
    return folder / "direct.toml"


def own_of(folder, name, model):
    """The same calibration with a model of its own."""
    text = f'schema = 1\n[model]\n{model}\n[data]\nfiles = ["fwd.csv"]\noutside = true\nmisfit = "weighted"\n'
    for layer, low, high, value in (("asphalt", 1000, 9000, 3000), ("base", 100, 900, 300), ("subgrade", 20, 180, 60)):
        text += f'[[parameters]]\nname = "{layer}.modulus_MPa"\nmin = {low}\nmax = {high}\nscale = "log"\nvalue = {value}\n'
    (folder / name).write_text(text + '[[outputs]]\nname = "strain"\nload = "fwd"\nquantity = "strain_xx"\nunit = "microstrain"\ndepth_mm = 99\n')
    return folder / name


def test_serve_speaks_the_protocol(pavement):
    folder, study, served = pavement
    assert served.ask("/Info") == {"protocolVersion": 1.0, "models": ["forward"]}
    assert served.ask("/ModelInfo")["support"] == {"Evaluate": True, "Gradient": True, "ApplyJacobian": True, "ApplyHessian": False}
    assert served.ask("/InputSizes", config={}) == {"inputSizes": [3]} and served.ask("/OutputSizes", config={}) == {"outputSizes": [9]}
    direct = json.loads(run("forward", study, "--json", "--jacobian").stdout)
    point = [[3000.0, 300.0, 60.0]]
    assert served.ask("/Evaluate", input=point, config={})["output"] == [[r["value"] for r in direct["responses"]]]
    jacobian = direct["jacobian"]["rows"]
    column = served.ask("/ApplyJacobian", outWrt=0, inWrt=0, input=point, vec=[0, 1, 0], config={})["output"]
    row = served.ask("/Gradient", outWrt=0, inWrt=0, input=point, sens=[0] * 8 + [1], config={})["output"]
    assert column == pytest.approx([r[1] for r in jacobian], rel=1e-12) and row == pytest.approx(jacobian[8], rel=1e-12)


@pytest.mark.parametrize("path, body, kind", [
    ("/Evaluate", {"name": "other", "input": [[1, 2, 3]]}, "ModelNotFound"),
    ("/Evaluate", {"input": [[1, 2]]}, "InvalidInput"),
    ("/Evaluate", {"input": [[1], [2], [3]]}, "InvalidInput"),
    ("/Evaluate", {"input": [["a", 2, 3]]}, "InvalidInput"),
    ("/Evaluate", {"input": [[-1, 300, 60]]}, "InvalidInput"),
    ("/Evaluate", {}, "InvalidInput"),
    ("/Gradient", {"outWrt": 1, "inWrt": 0, "input": [[3000, 300, 60]], "sens": [0] * 9}, "InvalidInput"),
    ("/Gradient", {"outWrt": 0, "inWrt": 0, "input": [[3000, 300, 60]], "sens": [0] * 8}, "InvalidInput"),
    ("/ApplyHessian", {"outWrt": 0, "inWrt1": 0, "inWrt2": 0, "input": [[3000, 300, 60]], "sens": [0] * 9, "vec": [1, 0, 0]}, "UnsupportedFeature"),
])
def test_serve_answers_errors_as_the_protocol_says(pavement, path, body, kind):
    answer = pavement[2].ask(path, **body)
    assert answer["status"] == 400 and answer["error"]["type"] == kind and answer["error"]["message"], answer


def test_serve_is_for_this_machine_and_no_page_of_another(pavement):
    url = pavement[2].url
    for header in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(urllib.request.Request(url + "/Info", headers=header), timeout=20)
        assert refused.value.code == 403


def test_the_built_in_model_through_a_server_and_through_a_program_ends_where_it_ends_itself(pavement):
    folder, study, served = pavement
    asked = ("--explore", 16, "--starts", 2, "--joint-only", "--json")

    def best(name):
        done = run("fit", name, *asked, "--out", folder / f"out-{name.stem}")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["best"]["parameters"]

    direct = best(study)
    through_server = own_of(folder, "served.toml", f'type = "um-bridge"\nurl = "{served.url}"')
    forward = [json.loads(run("forward", s, "--json").stdout)["responses"] for s in (study, through_server)]
    assert [r["value"] for r in forward[0]] == pytest.approx([r["value"] for r in forward[1]], rel=1e-14)
    assert best(through_server) == pytest.approx(direct, rel=1e-5)
    # The program reads the moduli and writes a table of its readings.
    (folder / "points.tmpl").write_text("asphalt.modulus_MPa,base.modulus_MPa,subgrade.modulus_MPa\n{{asphalt.modulus_MPa}},{{base.modulus_MPa}},{{subgrade.modulus_MPa}}\n")
    program = (f'type = "program"\ncommand = ["{PROGRAM}", "forward", "direct.toml", "--points", "points.csv", "--json"]\n'
               'inputs = [{ template = "points.tmpl", file = "points.csv" }]\nfiles = ["direct.toml", "fwd.csv"]\noutputs = [\n')
    labels = [f"fwd.deflection@{x},0,0" for x in (0, 200, 300, 450, 600, 900, 1200, 1500)] + ["strain"]
    program += "".join(f'{{ file = "stdout.txt", reading = "{label}", at = "/points/0/responses/{i}/value" }},\n' for i, label in enumerate(labels)) + "]"
    assert best(own_of(folder, "programmed.toml", program)) == pytest.approx(direct, rel=1e-4)


def test_sample_and_sensitivity_of_a_server():
    folder = workspace()
    url, _, server = serve(Model(), ("Evaluate", "ApplyJacobian"))
    study = decay(folder, url, ((0.1, 0.8), (0.9, 4)))
    sampled = run("sample", study, "--samples", 400, "--json", "--out", folder / "out")
    assert sampled.returncode == 0, sampled.stderr
    for parameter, value in zip(json.loads(sampled.stdout)["parameters"], (0.4, 1.6)):
        assert parameter["q025"] < value < parameter["q975"], parameter
    sensitive = run("sensitivity", study, "--samples", 32, "--json", "--out", folder / "out2")
    assert sensitive.returncode == 0, sensitive.stderr
    server.shutdown()
