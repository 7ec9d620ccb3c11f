"""Studies of random numbers, sensible and not: `check` takes a study or refuses it with one message, and what it takes no command
ever refuses or crashes on. --count: how many studies are taken in the second tier."""
import random
import re

import pytest

from support import *

folder = workspace()
LAWS = {"linear": {"modulus_MPa": 100, "poisson": 0.3},
        "uzan": {"k1": 2000, "k2": 0.5, "k3": -0.3, "n": 0.5, "poisson_12": 0.35, "poisson_31": 0.35},
        "k-theta": {"k1": 2000, "k2": 0.5, "poisson_12": 0.35, "poisson_31": 0.35},
        "uzan-deviator": {"k1": 2000, "k2": 0.5, "k3": -0.2, "poisson_12": 0.35, "poisson_31": 0.35},
        "uzan-separate": {"k1": 2000, "k2": 0.5, "k3": -0.2, "k1_horizontal": 600, "k2_horizontal": 0.8, "k1_shear": 500, "poisson_12": 0.35,
                          "poisson_31": 0.35},
        "dresden": {"q": 700, "c": 600, "q1": 0.5, "q2": 0.3, "poisson_12": 0.35, "poisson_31": 0.35},
        "lade-nelson": {"m": 800, "lambda": 0.3, "poisson": 0.3},
        "bilinear": {"modulus_MPa": 40, "slope_below": 800, "poisson_12": 0.4, "poisson_31": 0.4}}


def strange(value):
    """The value, near it, or far from it."""
    kind = random.random()
    if kind < 0.75:
        return value
    if kind < 0.85:
        return value * 10 ** random.uniform(-1, 1)
    return random.choice((0, -value, value * 1e3, value / 1e3, 1, 0.5, 1e-9, 1e6))


def layer(name, thickness):
    law = random.choice(list(LAWS))
    numbers = {"thickness_mm": thickness, "density_kg_m3": 2200, "k0": 0.5, **LAWS[law]}
    return f'[[layers]]\nname = "{name}"\nlaw = "{law}"\n' + "".join(f"{k} = {float(strange(v))!r}\n" for k, v in numbers.items()) + "\n"


def study():
    text = "schema = 1\n\n" + layer("asphalt", 40) + layer("base", 250) + (layer("subbase", 150) if random.random() < 0.3 else "") + layer("subgrade", 1200)
    text += f'[[loads]]\nname = "fwd"\ntype = "plate"\nradius_mm = {float(strange(150))!r}\npressure_kPa = {float(strange(600))!r}\n\n'
    text += f'[solver]\nintegration = "{random.choice(("incremental", "secant"))}"\n\n[mesh]\nextent_m = {float(strange(3))!r}\nrefine = 0.3\n\n'
    text += '[data]\nfiles = ["small.csv"]\nnoise_relative = 0.05\n\n'
    first = random.choice(re.findall(r'\[\[layers\]\]\nname = "(\w+)"\nlaw = "[\w-]+"\n(?:.*\n){3}(\w+) = ', text))
    text += f'[[parameters]]\nname = "{first[0]}.{first[1]}"\nmin = {float(strange(0.5))!r}\nmax = {float(strange(3000))!r}\nscale = "{random.choice(("log", "linear"))}"\n'
    return text + '\n[[outputs]]\nname = "top"\nload = "fwd"\nquantity = "strain_zz"\ndepth_mm = 320\n'


def tried(*command):
    """The finished command; None: it takes too long to wait for, which is not asked here."""
    try:
        return subprocess.run([PROGRAM, *map(str, command)], capture_output=True, text=True, timeout=20)
    except subprocess.TimeoutExpired:
        return None


def no_command_refuses_what_check_takes(studies):
    seed = random.SystemRandom().randrange(10**6)
    random.seed(seed)
    print(f"seed {seed}")
    taken = refused = slow = 0
    while taken < studies and refused < 40 * studies:
        text = study()
        file = write_study(folder, text)
        done = tried("check", file)
        if done is None:
            slow += 1
            continue
        assert done.returncode in (0, 1, 2), f"check ends with {done.returncode}:\n{done.stderr}\n{text}"
        if done.returncode == 2:
            refused += 1
            message = done.stderr.strip()
            assert len(message.splitlines()) == 1 and "small.toml" in message or "small.csv" in message, f"one message that names the file: {message}"
            continue
        taken += 1
        for command in (["forward"], ["map", "--design", "sobol", "--points", 6], ["fit", "--explore", 6, "--starts", 2],
                        ["sensitivity", "--samples", 0], ["twin", "--noise", 0.02]):
            out = [] if command[0] == "forward" else ["--out", folder / "out"]
            done = tried(command[0], file, *command[1:], *out)
            if done is None:
                slow += 1
                continue
            assert done.returncode in (0, 1), f"what check takes, {command[0]} ends with {done.returncode}: {done.stderr}\n{text}"
            assert done.returncode == 0 or done.stderr.strip() or done.stdout.strip(), f"{command[0]} says why it has no answer"
        shutil.rmtree(folder / "out", ignore_errors=True)
    print(f"{taken} studies taken, {refused} refused, {slow} commands too slow to wait for")
    assert taken == studies, "studies that check takes"


def test_what_check_takes_no_command_refuses():
    no_command_refuses_what_check_takes(2)


@pytest.mark.long
def test_what_check_takes_no_command_refuses_of_many():
    no_command_refuses_what_check_takes(COUNT or 40)
