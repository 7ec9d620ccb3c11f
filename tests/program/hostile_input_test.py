"""What nobody means to give and some file or shell gives all the same: numbers at the edge of what a number can be, bytes that are
no text, files that never end, signals, closed streams, several at once. One line says why; nothing crashes, nothing is taken in silence.
usage: hostile_input_test.py PROGRAM"""
import contextlib
import itertools
import json
import os
import re
import resource
import signal
import time
import unicodedata

from support import *

folder = workspace()
NOISY = STUDY.replace('misfit = "log"', 'misfit = "log"\nnoise_relative = 0.05')
TITLE = 'title = "A small study"'
SOBOL = ("--design", "sobol", "--points", 4)
ROWS = DATA.splitlines(keepends=True)
HANGS = 600  # seconds: nothing here takes a hundredth of them
cases = itertools.count(1)


def own_folder():
    path = folder / f"case-{next(cases)}"
    path.mkdir()
    return path


def changed(old, new, text=STUDY):
    assert old in text, f"the text holds '{old}'"
    return text.replace(old, new, 1)


def call(*arguments, limit=HANGS, names_bytes=False, **options):
    """As run(), for arguments that are bytes; what does not end has no exit status, and what it prints is text, unless it names bytes."""
    settings = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
    line = [PROGRAM, *(a if isinstance(a, bytes) else str(a) for a in arguments)]
    try:
        done = subprocess.run(line, timeout=limit, **settings)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(line, None, "", "")
    for stream in ("stdout", "stderr"):
        content = getattr(done, stream) or b""
        text = content.decode(errors="backslashreplace")
        assert names_bytes or text.encode() == content, f"{arguments[0]}: {stream} is not UTF-8: {text.strip()[-200:]}"
        setattr(done, stream, text)
    return done


def parsed(done, label):
    """The one JSON object on standard output."""
    try:
        found = json.loads(done.stdout)
    except json.JSONDecodeError:
        found = None
    assert isinstance(found, dict), f"{label}: no JSON object: {done.returncode} {done.stdout[:100]!r} {done.stderr.strip()[:300]}"
    return found if isinstance(found, dict) else {}


def case(study=STUDY, data=DATA):
    """A study in a folder of its own; text or bytes."""
    path = own_folder() / "small.toml"
    for file, content in ((path, study), (path.parent / "small.csv", data)):
        if content is not None:
            file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def one_line(done, statuses, label):
    """An exit status and one line on standard error; the line, or nothing where the status is another."""
    message = done.stderr.strip()
    assert done.returncode in statuses, f"{label}: exit status {done.returncode}, not {statuses}: {message[:300]}"
    if done.returncode not in statuses:
        return ""
    assert len(message.splitlines()) == 1, f"{label}: one line, not {len(message.splitlines())}: {message[:300]}"
    return message


def refused(done, label, *words, file="small.toml"):
    message = one_line(done, [2], label)
    if message:
        assert done.stdout == "", f"{label}: standard output is not empty: {done.stdout[:100]}"
        for word in (file, *words):
            assert word in message, f"{label}: '{word}' is missing: {message[:300]}"
    return message


def shown(message, label):
    """A message that a terminal can show, whole and with its reason."""
    if message:
        assert len(message) < 1000, f"{label}: {len(message)} characters"
        assert not any(unicodedata.category(c) == "Cc" for c in message), f"{label}: control characters: {message[:300]!r}"
        assert "allowed" in message or len(message.rpartition(": ")[2].split()) > 2, f"{label}: the reason is missing: {message[:300]}"
        assert message.count('"') % 2 == 0 or "..." in message, f"{label}: the message is cut off: {message[:300]}"


def begun(*arguments, **options):
    return subprocess.Popen([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            start_new_session=True, **options)


def until_caught(process, number):
    """Waits until a process catches a signal."""
    until = time.monotonic() + HANGS
    while process.poll() is None and time.monotonic() < until:
        with contextlib.suppress(OSError, TypeError):
            if int(re.search(r"SigCgt:\s*(\w+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1], 16) >> number - 1 & 1:
                return
        time.sleep(0.01)


def ended(process, limit):
    """What a process says before it ends; ended by force, with all that it started, when it does not."""
    try:
        out, err = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def limited(what, amount):
    def before():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(what, (amount, amount))
    return before


def test_whole_numbers_that_no_double_holds():
    for number in (2**53 + 1, 2**63 - 1):
        refused(call("forward", case(changed("pressure_kPa = 600", f"pressure_kPa = {number}"))), f"pressure {number}", "out of range", "pressure_kPa")


def test_numbers_so_small_that_what_is_divided_by_them_is_none():
    # Numbers so small that what is divided by them is none. What `fit` refuses, `check` does not recommend.
    WEIGHTED = changed('misfit = "log"', 'misfit = "weighted"')
    TINY = {"log_floor 1e-310": (changed('misfit = "log"', 'misfit = "log"\nlog_floor = 1e-310'), DATA),
            "sigma 1e-160": (WEIGHTED, re.sub(r"^(fwd.*)$", r"\g<1>1e-160", DATA, flags=re.M)),
            "noise_floor 1e-160": (changed('misfit = "weighted"', 'misfit = "weighted"\nnoise_floor = 1e-160', WEIGHTED), DATA),
            "a reading 1e-320": (changed('misfit = "log"', 'misfit = "relative"'), changed("0.95,mm", "1e-320,mm", DATA))}
    for label, files in TINY.items():
        path = case(*files)
        done = call("fit", path, "--explore", 10, "--starts", 2, "--out", path.parent / "out")
        one_line(done, [1, 2], f"fit, {label}")
        assert done.returncode != 2 or call("check", path).returncode != 0, f"check accepts what fit refuses: {label}"


def test_what_every_command_refuses_check_refuses():
    refused(call("check", case(changed('misfit = "log"', 'misfit = "relative"'), changed("0.21", "0", DATA))), "check: a reading of 0, relative",
            ":5:", file="small.csv")
    refused(call("check", case(STUDY, changed("0.0008", "0", DATA))), "check: a reading of 0 alone in its group", ":6:", file="small.csv")
    path = case(changed("min = 500", "min = 1e-320"))
    done = call("fit", path, "--explore", 10, "--starts", 2, "--out", path.parent / "out")
    assert done.returncode in (0, 1) and "inf" not in done.stderr, f"min = 1e-320 is no ratio that overflows: {done.returncode} {done.stderr.strip()}"


def test_grids_whose_size_no_integer_holds():
    # Grids whose size no integer holds: 2^64 + 230 and 2^64.
    LAYER = '[[layers]]\nname = "l{0}"\nthickness_mm = 50\ndensity_kg_m3 = 2000\nk0 = 0.5\nlaw = "linear"\nmodulus_MPa = {1}\npoisson = 0.35\n\n'
    AXIS = '[[parameters]]\nname = "l{}.modulus_MPa"\nmin = 10\nmax = 5000\nscale = "log"\npoints = {}\n\n'
    for points in ((2, 3, 19, 41, 97, 7103, 69341, 82609), (65536,) * 4):
        text = "schema = 1\n\n" + "".join(LAYER.format(i, 1000 // (i + 1) + 20) for i in range(9))
        text += STUDY[STUDY.index("[[loads]]"):STUDY.index("[[parameters]]")] + "".join(AXIS.format(i, p) for i, p in enumerate(points))
        path = case(text)
        label = f"{len(points)} parameters with {points[0]}, ... points"
        refused(call("map", path, "--out", path.parent / "out"), f"map, {label}", "points", file="")
        done = call("check", path)  # the other commands do without a grid
        assert done.returncode == 0 and "too many points" in done.stdout, f"check, {label}: {done.returncode} {done.stdout} {done.stderr}"


def test_options_that_are_no_numbers():
    path = case(NOISY)
    for arguments in (("twin", path, "--noise", "nan"), ("sensitivity", path, "--samples", 0, "--range", "nan"),
                      ("fit", path, "--explore", 10, "--starts", 1, "--model", "auto", "--model-error", "nan"),
                      ("map", path, *SOBOL, "--seed", "-1"), ("map", path, *SOBOL, "--seed", "9" * 23)):
        done = call(*arguments, "--out", path.parent / "out")
        label = f"{arguments[0]} {' '.join(arguments[-2:])}"
        assert done.returncode == 2 and done.stderr and not done.stdout, f"{label}: exit status {done.returncode}: {done.stderr.strip()}"


# Roads whose places are not numbers.
OFFSETS = "D0_um,D200_um,D300_um,D600_um,D900_um"
ROAD = f"station,lane,chainage_m,drop,radius_mm,pressure_kPa,{OFFSETS}\nA,L,0,1,150,600,700,500,400,200,100\nB,L,10,1,150,600,710,510,410,210,110\n"
F25 = ('5001,25,50,1\n5020,150,0,200,300,600,900\n5301,0,1,5,2,1.0,1,0,"L1"\n5303,0,0,20,15\n1,600,700,500,400,200,100\n'
       '5301,0,1,5,2,2.0,1,0,"L1"\n1,600,700,500,400,200,100\n')
PDDX = """[Pavement Deflection Data Exchange File]
[Device Configuration]
LoadPlateRadius = 150
NumberOfDeflectionSensors = 5
DeflectionSensorXAxisDistances = 0,200,300,600,900
[Units]
LoadPlateRadiusUnits = mm
DeflectionUnits = um
LoadUnits = kPa
SensorLocationUnits = mm
TestLocationUnits = m
[Test Location 1]
TestLocation = 1.5
TestLane = L
DropData1 = 600,700,500,400,200,100
"""


def road(name, content, *options):
    path = own_folder() / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return call("survey", path, "--out", path.parent / "out", *options)


def test_sound_roads_are_read():
    for name, content in (("road.csv", ROAD), ("road.f25", F25), ("road.ddx", PDDX)):
        done = road(name, content)
        assert done.returncode == 0, f"survey of a sound {name}: {done.returncode} {done.stderr.strip()}"


def test_places_that_are_no_numbers():
    for word in ("nan", "inf"):
        # A place of a sensor that is not a number costs that sensor, a station's place that place.
        for name, content in (("road.f25", F25), ("road.ddx", PDDX)):
            done = road(name, changed("0,200,", f"0,{word},", content), "--json")
            assert done.returncode == 0, f"{name}, a place {word}: {done.returncode} {done.stderr.strip()}"
            result = parsed(done, f"{name}, a place {word}")
            assert all(200 not in [r["offset_mm"] for r in s.get("readings", [])] for s in result["stations"]), f"{name}, a place {word}: no sensor there"
            assert any("line" in f and "place" in f for f in result["findings"]), f"{name}, a place {word}, is said: {result['findings']}"
        for name, content, old, new in (("road.csv", ROAD, "B,L,10,", f"B,L,{word},"), ("road.f25", F25, "2,2.0,", f"2,{word},"),
                                        ("road.ddx", PDDX, "= 1.5", f"= {word}")):
            done = road(name, changed(old, new, content), "--json")
            assert done.returncode == 0, f"{name}, a chainage {word}: {done.returncode} {done.stderr.strip()}"
            assert [s["chainage_m"] for s in parsed(done, f"{name}, a chainage {word}")["stations"]][-1] is None, f"{name}, a chainage {word}"


def test_text_that_is_not_utf8():
    # Text that is not UTF-8. An instrument writes Latin-1, and its road is read; a study is not guessed at.
    done = road("road.csv", changed("A,L", "Aé,L", ROAD).encode("latin-1"), "--json")
    assert done.returncode == 0, f"a road in Latin-1: {done.returncode} {done.stderr.strip()}"
    assert "Aé" in [s["station"] for s in parsed(done, "a road in Latin-1").get("stations", [])], f"a station in Latin-1: {done.stdout[:200]}"
    path = case()
    out = os.fsencode(path.parent) + b"/out\xff"
    done = call("map", path, *SOBOL, "--out", out, names_bytes=True)
    assert done.returncode == 0, f"a folder whose name is no text: {done.returncode} {done.stderr.strip()}"
    if os.path.exists(out + b"/map.json"):
        assert json.loads(pathlib.Path(os.fsdecode(out), "map.json").read_text("utf-8"))["points"] == 4, "its map.json"
    done = call("twin", path, "--json", "--out", out)
    assert len(parsed(done, "twin, a folder whose name is no text").get("measurements", [])) == 4, f"twin, a folder whose name is no text: {done.stderr.strip()}"
    path = case(data=changed("fwd,deflection,0", "fw\xff,deflection,0", DATA).encode("latin-1"))
    refused(call("map", path, *SOBOL, "--out", path.parent / "out"), "a load that is not UTF-8", file="small.csv:3:")


def test_what_a_terminal_cannot_show():
    HOSTILE = {"UTF-16": (STUDY, DATA.encode("utf-16")), "a cell with a zero byte": (STUDY, changed("0.95", "0\0.95", DATA)),
               "a load with a zero byte": (STUDY, changed("fwd,", "fw\0d,", DATA)), "a number of 5 MB": (STUDY, changed("0.95", "9" * 5_000_000, DATA)),
               "a load of 5 MB": (STUDY, changed("fwd,", "f" * 5_000_000 + ",", DATA)), "a load with an ESC": (STUDY, changed("fwd,", "fw\x1b[2Jd,", DATA)),
               "a load with a line break": (STUDY, changed("fwd,", '"fw\nd",', DATA)), "a key with a line break": (changed(TITLE, TITLE + '\n"a\\nb" = 1'), DATA),
               "a key with an ESC": (changed(TITLE, TITLE + '\n"a\\u001b[2J" = 1'), DATA)}
    for label, files in HOSTILE.items():
        path = case(*files)
        shown(refused(call("map", path, *SOBOL, "--out", path.parent / "out"), label, file="small.toml" if files[1] == DATA else "small.csv"), label)


def test_keys_deeper_than_any_stack():
    for label, text in (("a key of 60,000 parts", changed(TITLE, TITLE + "\n" + ".".join("a" * 60_000) + " = 1")),
                        ("a header of 120,000 parts", STUDY + "\n[" + ".".join("a" * 120_000) + "]\n")):
        shown(refused(call("check", case(text)), label), label)


def report_of(name, content):
    out = own_folder()
    (out / name).write_text(content)
    return call("report", out)


def test_a_report_of_what_is_no_result():
    assert report_of("fit.json", '{"a":' + "[" * 120_000 + "]" * 120_000 + "}").returncode == 2, "report: 120,000 brackets"
    for content in ('{"study": 5}', '{"study": {"file": null}}', "[]"):
        one_line(report_of("fit.json", content), [2], f"report of {content}")


def test_a_column_twice():
    # The measurement file: columns, some readings with a standard deviation.
    twice = [re.sub(r"^((?:[^,]*,){6})", r"\g<1>" + ("value," if row.startswith("load") else "7,"), row) for row in ROWS[1:]]
    message = refused(call("forward", case(data="".join(twice))), "a column twice", file="small.csv:1:")
    assert re.search('value(: |")', message) or not message, f"a column twice: it is named: {message}"


def test_some_readings_with_a_standard_deviation():
    path = case(data=changed("0.95,mm,", "0.95,mm,0.02", DATA))
    done = call("forward", path)
    assert done.returncode == 0, f"one reading states its noise, forward: {done.returncode} {done.stderr.strip()}"
    fit = ("fit", path, "--explore", 10, "--starts", 2, "--out", path.parent / "out")
    noise = parsed(call(*fit, "--json"), "one reading states its noise, fit").get("noise", {})
    assert noise.get("source") == "partly stated", f"one reading states its noise, fit: {noise}"
    text = " ".join(call(*fit, "--verbose").stdout.split())
    assert re.search(r"(?<![.\d])3(?![.\d])[^.]*\bstate[sd]?\b|\bstate[sd]?\b[^.]*(?<![.\d])3(?![.\d])", text), f"3 readings state no noise: {text[-600:]}"


def test_files_that_are_none_or_never_end():
    path = case(changed('"small.csv"', f'"{"a" * 5000}"'))
    refused(call("check", path), "a file name of 5000 characters")
    path = case(data=None)
    (path.parent / "small.csv").symlink_to("small.csv")
    refused(call("check", path), "a link to itself", file="small.")
    path = case(data=None)
    os.mkfifo(path.parent / "small.csv")
    os.mkfifo(path.parent / "pipe.toml")
    refused(call("check", path, limit=30), "a pipe as measurement file", file="small.")
    refused(call("check", path.parent / "pipe.toml", limit=30), "a pipe as study", file="pipe.toml")
    if not sanitizer():  # which needs all addresses
        process = begun("check", "/dev/zero", env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}, preexec_fn=limited(resource.RLIMIT_AS, 2**32))
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        refused(subprocess.CompletedProcess([], process.returncode, *process.communicate()), "a device as study", file="/dev/zero")
        assert usage.ru_maxrss < 2**19, f"a device as study: read to {usage.ru_maxrss / 2**20:.1f} GB"


def test_links_out_of_the_folder():
    (folder / "elsewhere.csv").write_text(DATA)
    for link, outside, status in (("../elsewhere.csv", "", 2), ("../elsewhere.csv", "\noutside = true", 0), ("beside.csv", "", 0)):
        path = case(changed('files = ["small.csv"]', f'files = ["small.csv"]{outside}'), data=None)
        (path.parent / "beside.csv").write_text(DATA)
        (path.parent / "small.csv").symlink_to(link)
        done, label = call("forward", path), f"a link to {link} {outside.strip()}"
        if status == 2:
            refused(done, label, "outside", file="small.")
        else:
            assert done.returncode == 0, f"{label}: exit status {done.returncode}: {done.stderr.strip()}"


def test_names_that_a_measurement_file_could_take_for_something_else():
    for label, study, data in (("a title with a line break", changed(TITLE, 'title = "line one\\nline two"'), DATA),
                               ("a load named #1", STUDY.replace('"fwd"', '"#1"'), re.sub("^fwd", '"#1"', DATA, flags=re.M))):
        path = case(study, data)
        done = call("twin", path, "--out", path.parent / "out")
        assert done.returncode == 0, f"{label}: twin: {done.returncode} {done.stderr.strip()}"
        if done.returncode == 0:
            shutil.copy(path.parent / "out" / "twin.csv", path.parent / "small.csv")
        done = call("forward", path, "--json")
        assert done.returncode == 0, f"{label}: its twin: {done.returncode} {done.stderr.strip()}"
        assert len(parsed(done, f"{label}: its twin").get("responses", [])) == 5, f"{label}: its twin holds four readings, the study one output"


def test_no_answer_is_said_in_json_too():
    impossible = case(changed("min = 0.1\nmax = 4.5", "min = 4.4\nmax = 4.5", NOISY))
    secant = case(changed("k2 = 0.5", "k2 = 2.1", changed("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]')))
    for path, arguments in ((impossible, ("map", *SOBOL)), (impossible, ("unique", "--explore", 8, "--verify", 2)),
                            (impossible, ("compare", "--explore", 8, "--verify", 2, "--laws", "uzan,k-theta")), (secant, ("twin",))):
        label = f"{arguments[0]} without an answer"
        done = call(arguments[0], path, *arguments[1:], "--json", "--out", path.parent / arguments[0])
        one_line(done, [1], label)
        found = parsed(done, label)
        words = f"{label}: status {found.get('status')}, reason {found.get('reason')}"
        assert found.get("status", "converged") != "converged" and found.get("reason"), words


# Repeated: commands of several parts, two studies in one folder, a study after "--".
def same(path, label):
    done = call("rerun", path.parent / "out")
    words = f"rerun of {label}: {done.returncode} {done.stdout.strip()} {done.stderr.strip()}"
    assert done.returncode == 0 and "The same to the last bit" in done.stdout, words


def test_commands_of_several_parts_are_repeated():
    for arguments in (("diagnose", "--explore", 8, "--starts", 1, "--bootstrap", 2), ("compare", "--explore", 8, "--verify", 2, "--laws", "uzan,linear")):
        path = case(NOISY)
        done = call(arguments[0], path, *arguments[1:], "--out", path.parent / "out")
        assert done.returncode == 0, f"{arguments[0]}: {done.stderr.strip()}"
        same(path, arguments[0])


def test_two_studies_in_one_folder_are_repeated():
    path = case(NOISY)
    (path.parent / "other.toml").write_text(changed("k1 = 2000", "k1 = 2001", NOISY))
    for name in ("small.toml", "other.toml"):
        assert call("map", path.parent / name, *SOBOL, "--out", path.parent / "out").returncode == 0, f"map of {name}"
    same(path, "two studies in one folder")


def test_a_study_after_two_dashes_is_repeated():
    path = case(NOISY)
    assert call("map", *SOBOL, "--out", path.parent / "out", "--", "small.toml", cwd=path.parent).returncode == 0, "map ... -- small.toml"
    same(path, "map ... -- small.toml")


def test_standard_error_that_nobody_reads():
    path = case()
    twin = call("twin", path, "--out", path.parent / "out").stdout
    with open("/dev/full", "w") as full:
        for label, options in (("closed", {"preexec_fn": lambda: os.close(2)}), ("full", {"stderr": full})):
            done = call("check", path.parent / "nofile.toml", **options)
            assert done.returncode == 2, f"standard error is {label}, check: exit status {done.returncode}"
            done = call("twin", path, "--out", path.parent / "out", **options)
            assert done.stdout == twin, f"standard error is {label}, twin: {len(done.stdout)} of {len(twin)} characters on standard output"


def test_three_at_once_into_one_folder():
    path = case(data=DATA + 2000 * "fwd,deflection,300,0,0,0,520,um,\n")
    out = path.parent / "out"
    lines = [[PROGRAM, "twin", str(path), "--noise", "0.1", "--seed", str(seed), "--out", str(out)] for seed in (1, 2, 3)]
    whole = [subprocess.run(line, capture_output=True, timeout=HANGS).stdout for line in lines]
    ends, torn, left = [], 0, set()
    for _ in range(60):  # 20 may pass without a collision
        together = [subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for line in lines]
        ends += [process.wait(HANGS) for process in together]
        torn += (out / "twin.csv").read_bytes() not in whole
        left |= {name for name in os.listdir(out) if name != "twin.csv"}
    assert set(ends) == {0}, f"three at once: exit statuses {sorted(set(ends))}, {sum(e != 0 for e in ends)} of {len(ends)} not 0"
    assert torn == 0, f"three at once: {torn} of 60 files are not one of the three"
    assert not left, f"three at once: left behind: {left}"


def test_a_disk_without_room_is_no_wrong_input():
    # A disk without room: the computation failed, the input is not wrong.
    path = case(NOISY)
    for arguments, room in ((("twin",), 100), (("fit", "--explore", 10, "--starts", 2), 1_000), (("fit", "--explore", 10, "--starts", 2), 30_000)):
        done = call(arguments[0], path, *arguments[1:], "--out", path.parent / "full", preexec_fn=limited(resource.RLIMIT_FSIZE, room))
        one_line(done, [1], f"{arguments[0]} with room for {room} bytes")


def test_readings_in_place_of_a_study():
    # Readings in place of a study: what they are, and what takes them.
    for name, words in (("road-north.f25", ("FWD readings", "survey FILE --study", "new --from")), ("road-example.csv", ("FWD readings",)),
                        ("captif-p1-fwd.csv", ("a file of readings", "[data] files"))):
        for command in ("unique", "check"):
            refused(call(command, ROOT / "grids" / name), f"{command} {name}", *words, file=name)


def test_more_threads_than_there_is_memory_for():
    # Runs in three dimensions on more threads than there is memory for are refused before the first; fewer are told.
    path = case((ROOT / "grids" / "dual-nonlinear.toml").read_text().replace("[mesh]", "[mesh]\nrefine = 2"), None)
    room = 2_000_000_000
    for command in ("check", "sensitivity"):
        done = call(command, path, "--threads", 4, preexec_fn=limited(resource.RLIMIT_AS, room))
        message = done.stderr.strip().splitlines()[-1]
        assert done.returncode == 2 and "need more memory than there is" in message and "2.0 GB in all" in message, f"{command}: {done.returncode} {message}"
        fit, gigabytes = int(re.search(r"--threads (\d)", message)[1]), float(re.search(r"some ([\d.]+) GB a thread", message)[1])
        assert fit * gigabytes <= 2.0 < (fit + 1) * (gigabytes + 0.05), f"{command}: as many as have room: {message}"


# Signals, in the middle of one long run of the model.
patience = 600 if sanitizer() else 30
path = case(changed("refine = 0.4", "refine = 12"))


def test_signals_in_the_middle_of_a_long_run():
    for command, options in (("forward", []), ("twin", ["--out", path.parent / "out"]), ("check", ["--time"])):
        for number in (signal.SIGTERM, signal.SIGINT):
            process = begun(command, path, *options)
            until_caught(process, number)
            time.sleep(1)
            process.send_signal(number)
            done = ended(process, patience)
            done.stderr = done.stderr.removeprefix("runs are timed ...\n") # what check says that it waits for
            if one_line(done, [130], f"{command}, {number.name}"):
                assert done.stdout == "", f"{command}, {number.name}: nothing on standard output: {done.stdout[:100]}"


def test_a_run_that_is_kept_says_what_it_waits_for():
    # A run that is kept waits for what is computed, and says so at once; told twice it ends.
    process = begun("map", path, "--out", path.parent / "awaited")
    until_caught(process, signal.SIGINT)
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    said = said_until("second", process, 5)
    assert "waiting for the evaluations" in said and process.poll() is None, f"what is awaited is said: {said!r} {process.poll()}"
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    assert ended(process, patience).returncode == 130 and time.monotonic() - begin < patience / 3, "a second Ctrl-C ends at once"


def test_sigterm_does_not_wait():
    # Who sends SIGTERM does not wait: neither does the program, for a run that takes longer.
    process = begun("map", path, "--out", path.parent / "ended")
    until_caught(process, signal.SIGTERM)
    time.sleep(1)
    begin = time.monotonic()
    process.send_signal(signal.SIGTERM)
    done = ended(process, patience)
    assert done.returncode == 130 and time.monotonic() - begin < patience, f"SIGTERM: {done.returncode} {done.stderr}"
    # Whether the run that was in progress ended within its five seconds is the machine's.
    assert "what was finished is kept" in done.stderr or "what was computed is kept" in done.stderr, f"SIGTERM: {done.stderr}"


def test_signals_in_the_middle_of_a_repetition():
    # And in the middle of a repetition: to the program alone, as `kill` sends it, and to all that a terminal started, as Ctrl-C does.
    path = case(NOISY)
    out = path.parent / "out"
    process = begun("map", path, "--design", "sobol", "--points", 50_000, "--out", out)
    while evaluations(out) < 5 and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert ended(process, HANGS).returncode == 130, "a long run is interrupted"
    scratch = folder / "scratch"
    scratch.mkdir()
    for send, number in ((os.kill, signal.SIGTERM), (os.killpg, signal.SIGINT)):
        process = begun("rerun", out, env={**os.environ, "TMPDIR": str(scratch)})
        until = time.monotonic() + HANGS
        while not any(evaluations(run_folder) for run_folder in scratch.glob("pavescape-*")) and process.poll() is None and time.monotonic() < until:
            time.sleep(0.01)
        send(process.pid, number)
        done = ended(process, patience)
        done.stderr = "".join(line for line in done.stderr.splitlines(keepends=True) if line.strip() and not line.startswith(("repeating: ", "waiting for ")))
        message = one_line(done, [130], f"rerun, {number.name}")
        assert "the same command continues" not in message, f"rerun, {number.name}: nothing of it is kept: {message}"
        left = [rest.name for rest in scratch.glob("pavescape-*")]
        assert not left, f"rerun, {number.name}: left behind: {left}"
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
            assert False, f"rerun, {number.name}: something of it goes on"
        for rest in scratch.iterdir():
            shutil.rmtree(rest, ignore_errors=True)
