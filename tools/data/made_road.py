"""Made-up stations of grids/road-together.toml with k2 0.5 and k3 -0.3 everywhere, k1 and subgrade their own, three load levels of two drops, for
tools/trials/road, road-diagnosis and survey. Stations are computed on the study's own mesh: what is tried is the statistics, not the mesh."""
import concurrent.futures
import json
import math
import os
import pathlib
import random
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "output" / "road-trials"  # exact deflections are kept here
OFFSETS, PRESSURES = (0, 200, 300, 450, 600, 900, 1200), (400, 570, 760)
TRUTH = {"base.k2": 0.5, "base.k3": -0.3, "asphalt.modulus_MPa": 3000.0}
TEXT = (ROOT / "grids" / "road-together.toml").read_text()
TEXT = TEXT[:TEXT.index("[[outputs]]")]


def exact(program, station, change=lambda section: section, offsets=OFFSETS):
    """Deflections in um at every pressure. change: of the text of the section with the station's parameters in it."""
    section = TEXT[:TEXT.index("[data]")]
    for old, new in (("k1 = 2500", f"k1 = {station['base.k1']}"), ("modulus_MPa = 60", f"modulus_MPa = {station['subgrade.modulus_MPa']}")):
        assert section.count(old) == 1
        section = section.replace(old, new)
    section = change(section)
    load = section[section.index("[[loads]]"):]
    section = section.replace(load, "".join(load.replace('"fwd"', f'"p{p}"').replace("= 566", f"= {p}") for p in PRESSURES))
    for p in PRESSURES:
        for o in offsets:
            section += f'[[outputs]]\nname = "p{p}D{o}"\nload = "p{p}"\nquantity = "deflection"\nx_mm = {o}\n'
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "station.toml"
        file.write_text(section)
        done = subprocess.run([program, "forward", file, "--json"], capture_output=True, text=True, check=True)
    values = [1e3 * r["value"] for r in json.loads(done.stdout)["responses"]]
    return [values[i:i + len(offsets)] for i in range(0, len(values), len(offsets))]


def stations_and_bowls(program, count):
    """([{parameter: its value at the station}], [deflections in um, a list a pressure])"""
    WORK.mkdir(parents=True, exist_ok=True)
    chance = random.Random(11)
    stations = [{"base.k1": round(3000 * 2 ** chance.uniform(-0.7, 0.7), 1), "subgrade.modulus_MPa": round(60 * 2 ** chance.uniform(-0.7, 0.7), 2)}
                for _ in range(count)]
    kept = WORK / "exact.json"
    bowls = json.loads(kept.read_text()) if kept.exists() else []
    if len(bowls) < count:
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as threads:
            bowls += list(threads.map(lambda s: exact(program, s), stations[len(bowls):]))
        kept.write_text(json.dumps(bowls))
    return stations, bowls


class Noise:
    """Errors of deflections: relative and absolute (um) of every sensor, correlated along them, and in common for a level (relative)."""

    def __init__(self, relative, absolute, common=0.0, correlation_mm=0.0):
        self.relative, self.absolute, self.common, self.correlation_mm = relative, absolute, common, correlation_mm

    def words(self):
        return (f"\n[data.noise]\nrelative = {self.relative}\nabsolute = {{ um = {self.absolute} }}\ncommon_relative = {self.common}\n"
                f"correlation_mm = {self.correlation_mm}\n")

    def spoilt(self, bowl, chance):
        own = []
        for i, offset in enumerate(OFFSETS):  # exp(-distance / length) is that of a first-order process along the offsets
            rho = math.exp(-(offset - OFFSETS[i - 1]) / self.correlation_mm) if i and self.correlation_mm else 0.0
            own.append(rho * (own[-1] if i else 0.0) + math.sqrt(1 - rho * rho) * chance.gauss(0, 1))
        common = chance.gauss(0, self.common)
        return [d + math.hypot(self.relative * d, self.absolute) * e + common * d for d, e in zip(bowl, own)]


def write_study(name, noise):
    file = WORK / f"{name}.toml"
    file.write_text(TEXT + noise.words())
    return file


def write_road(name, stations, bowls, noise, seed):
    """The drops of a level repeat within 0.05 %, so that what the study states of the noise is all there is."""
    chance = random.Random(seed)
    lines = ["station,chainage_m,drop,radius_mm,pressure_kPa," + ",".join(f"D{o}_um" for o in OFFSETS)]
    for i in stations:
        drop = 0
        for pressure, bowl in zip(PRESSURES, bowls[i]):
            level = noise.spoilt(bowl, chance)
            for _ in range(2):
                drop += 1
                lines.append(f"P{i:03},{25 * i},{drop},150,{pressure}," + ",".join(f"{d * (1 + 0.0005 * chance.gauss(0, 1)):.3f}" for d in level))
    file = WORK / f"{name}.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def holds(p, value):
    return p["low"] <= value <= p["high"]
