"""Studies of a made-up station, whose runs take seconds each: for pictures of pages and figures."""
import subprocess

from options import ROOT

LAYERS = ("--layers", "asphalt 120, base 300, subgrade", "--linear")
AXLE = """
[[loads]]
name = "wheel"
type = "wheel"
force_kN = 40
pressure_kPa = 750
patch = "circle"

[[criteria]]
name = "rutting"
law = "austroads-subgrade"
axle = "wheel"
traffic_per_year = 1e5

[[criteria]]
name = "cracking"
law = "asphalt-institute-fatigue"
axle = "wheel"
traffic_per_year = 1e5
"""


def run(program, *words):
    subprocess.run([program, *map(str, words)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def make_studies(program, folder):
    """Writes them, where they are not there yet. {name: file}: `bowl`, what the model of a new study would read; `loose`, the same with more noise stated;
    `weak`, the same more exactly and with an effect that it lacks; `rigid`: `weak` on rock at 3 m; `axle`: `bowl` with two criteria; `gauges`: a new study
    of strain gauges."""
    names = {name: folder / f"{name}.toml" for name in ("bowl", "loose", "weak", "rigid", "axle", "gauges")}
    new = folder / "new.toml"
    if not new.exists():
        run(program, "new", new, *LAYERS)
        run(program, "new", names["gauges"], *LAYERS, "--gauges", "200,260,320,380,480,600")
    exact = new.read_text().replace("noise_relative = 0.02", "noise_relative = 0.005").replace("noise_floor = 0.005", "noise_floor = 0.001")
    for name, text, effect, noise in (("bowl", new.read_text(), [], 0.01), ("weak", exact, ["--effect", "weak-subgrade-top=0.5"], 0.005)):
        if not (folder / f"data-{name}").exists():
            run(program, "twin", new, *effect, "--noise", noise, "--out", folder / f"data-{name}")
        names[name].write_text(text.replace('"new.csv"', f'"data-{name}/twin.csv"'))
    names["loose"].write_text(names["bowl"].read_text().replace("noise_relative = 0.02", "noise_relative = 0.1"))
    names["rigid"].write_text(names["weak"].read_text().replace('bottom = "half-space"', 'bottom = "rigid"')
                              .replace('name = "subgrade"\n', 'name = "subgrade"\nthickness_mm = 3000\n'))
    names["axle"].write_text(names["bowl"].read_text() + AXLE)
    return names
