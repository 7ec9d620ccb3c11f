"""The demo study inverted as a user would without this program's derivatives: scipy.optimize.least_squares with finite
differences, driving `pavescape forward --json`.

usage: scipy_inversion.py PAVESCAPE STUDY [START ...]      START: unit coordinates, comma separated
Prints one JSON object a start: seconds, forward runs, misfit, parameters.
"""
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time

import numpy
from scipy.optimize import least_squares


def read_study(file):
    """The text of the study, its parameters with their ranges, and the value of every key of [data]."""
    import tomllib

    with open(file, encoding="utf-8") as f:
        text = f.read()
    return text, tomllib.loads(text)


def with_values(text, study, values):
    """The study with other values of its parameters (LAYER.KEY)."""
    blocks = re.split(r"(?m)^(?=\[)", text)
    for parameter, value in zip(study["parameters"], values):
        owner, key = parameter["name"].split(".")
        for i, block in enumerate(blocks):
            if block.startswith("[[layers]]") and re.search(rf'(?m)^name = "{owner}"', block):
                blocks[i] = re.sub(rf"(?m)^{key} = \S+", f"{key} = {value:.17g}", block)
    return "".join(blocks)


class Inversion:
    def __init__(self, program, file):
        self.program = program
        self.text, self.study = read_study(file)
        self.folder = os.path.dirname(os.path.abspath(file))
        with open(os.path.join(self.folder, self.study["data"]["files"][0]), encoding="utf-8") as f:
            self.measured = numpy.array(
                [float(row["value"]) for row in csv.DictReader(line for line in f if not line.startswith("#"))])
        self.small = self.study["data"]["log_floor"] * abs(self.measured).max()
        self.runs = 0

    def physical(self, unit):
        values = []
        for p, u in zip(self.study["parameters"], unit):
            if p.get("scale") == "log":
                values.append(p["min"] * (p["max"] / p["min"]) ** u)
            else:
                values.append(p["min"] + u * (p["max"] - p["min"]))
        return values

    def residuals(self, unit):
        self.runs += 1
        with tempfile.NamedTemporaryFile("w", suffix=".toml", dir=self.folder) as f:
            f.write(with_values(self.text, self.study, self.physical(unit)))
            f.flush()
            out = subprocess.run([self.program, "forward", f.name, "--json"], capture_output=True, text=True, check=True)
        model = numpy.array([r["value"] for r in json.loads(out.stdout)["responses"][: len(self.measured)]])
        return numpy.arcsinh(model / (2 * self.small)) - numpy.arcsinh(self.measured / (2 * self.small))

    def run(self, start):
        begin = time.monotonic()
        self.runs = 0
        end = least_squares(self.residuals, numpy.clip(start, 1e-6, 1 - 1e-6), bounds=(0, 1), xtol=1e-5, ftol=1e-7)
        return {"seconds": time.monotonic() - begin, "runs": self.runs, "misfit": math.sqrt(2 * end.cost),
                "parameters": self.physical(end.x)}


if __name__ == "__main__":
    inversion = Inversion(sys.argv[1], sys.argv[2])
    for start in sys.argv[3:]:
        print(json.dumps(inversion.run([float(u) for u in start.split(",")])), flush=True)
