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
    """Writes them, where they are not there yet. {name: file}: `bowl` and `weak`, what the model of a new study would read, without and with an effect
    that it lacks; `rigid`: `weak` on rock at 3 m; `axle`: `bowl` with two criteria; `gauges`: a new study of strain gauges."""
    names = {name: folder / f"{name}.toml" for name in ("bowl", "weak", "rigid", "axle", "gauges")}
    new = folder / "new.toml"
    if not new.exists():
        run(program, "new", new, *LAYERS)
        run(program, "new", names["gauges"], *LAYERS, "--gauges", "200,260,320,380,480,600")
    for name, effect in (("bowl", []), ("weak", ["--effect", "weak-subgrade-top=0.7"])):
        if not (folder / f"data-{name}").exists():
            run(program, "twin", new, *effect, "--noise", "0.01", "--out", folder / f"data-{name}")
        names[name].write_text(new.read_text().replace('"new.csv"', f'"data-{name}/twin.csv"'))
    names["rigid"].write_text(names["weak"].read_text().replace('bottom = "half-space"', 'bottom = "rigid"')
                              .replace('name = "subgrade"\n', 'name = "subgrade"\nthickness_mm = 3000\n'))
    names["axle"].write_text(names["bowl"].read_text() + AXLE)
    return names
