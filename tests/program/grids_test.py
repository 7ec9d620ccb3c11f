"""Every study in grids/ runs, and gives what its '# test:' lines say.

# test: forward FIRST-LAST = VALUE VALUE ... within PERCENT %      rows counted from 1, values in the unit of the data
"""
import json
import re

from support import *

studies = sorted((ROOT / "grids").glob("*.toml"))
check(len(studies) > 0, "there are studies")
for study in studies:
    done = run("forward", study, "--json")
    check(done.returncode == 0, f"{study.name}: {done.stderr}")
    if done.returncode != 0:
        continue
    values = [r["value"] for r in json.loads(done.stdout)["responses"]]
    tests = re.findall(r"^# test: (.*)$", study.read_text(), re.M)
    check(tests, f"{study.name} says what it must give")
    for line in tests:
        match = re.fullmatch(r"forward (\d+)-(\d+) = ([-\d. e]+) within ([\d.]+) %", line)
        check(match, f"{study.name}: '{line}' is not understood")
        if match:
            first, last = int(match[1]), int(match[2])
            wanted = [float(v) for v in match[3].split()]
            check(len(wanted) == last - first + 1, f"{study.name}: '{line}' names as many rows as values")
            for value, want in zip(values[first - 1:last], wanted):
                check(abs(value / want - 1) <= float(match[4]) / 100, f"{study.name}: {value}, not {want}")
    print(study.name, "ok")
finish()
