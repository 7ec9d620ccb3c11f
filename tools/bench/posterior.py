"""Independent draws from the posterior of a study by an affine-invariant ensemble (Goodman and Weare 2010, doi
10.2140/camcos.2010.5.65) that calls the full model through the Python module, and the cost of the full model with derivatives.

usage: posterior.py MODULE_FOLDER STUDY SAMPLES_CSV STEPS
STUDY: readings in one file, their noise by noise_relative and noise_floor; SAMPLES_CSV: of `pavescape sample` on it; the walkers
begin at some of its draws, and its densities must be those that are written down here. Prints one JSON object.
"""
import csv
import json
import os
import sys
import time
import tomllib

import numpy as np

WALKERS = 24
STRETCH = 2.0
RUNS = 200  # with derivatives


def rows_of(file):
    with open(file, encoding="utf-8") as f:
        return list(csv.DictReader(line for line in f if not line.startswith("#")))


class Posterior:
    """Independent errors, normal on the scale asinh(b v / a) / b where their size is the same everywhere, about its mean (docs/theory/theory.md; b
    relative, a the floor), a flat prior on the scales of the parameters. Coordinates from 0 to 1."""

    def __init__(self, module, file):
        self.study = module.Study(file)
        with open(file, "rb") as f:
            text = tomllib.load(f)
        self.is_log = np.array([p.get("scale") == "log" for p in text["parameters"]])
        self.ends = [np.where(self.is_log, np.log(np.where(self.is_log, end, 1.0)), end) for end in (self.study.low, self.study.high)]
        data = text["data"]
        self.measured = 1e-3 * np.array([float(r["value"]) for r in rows_of(os.path.join(os.path.dirname(file), data["files"][0]))])  # mm
        self.relative, self.floor = data["noise_relative"], data["noise_floor"] * abs(self.measured).max()

    def physical(self, u):
        on_scale = self.ends[0] + u * (self.ends[1] - self.ends[0])
        return np.where(self.is_log, np.exp(on_scale), on_scale)

    def unit(self, values):
        on_scale = np.where(self.is_log, np.log(np.where(self.is_log, values, 1.0)), values)
        return (on_scale - self.ends[0]) / (self.ends[1] - self.ends[0])

    def log_density(self, u):
        if (u <= 0.0).any() or (u >= 1.0).any():
            return -np.inf
        model = 1e-3 * np.asarray(self.study.forward(self.physical(u)))[: len(self.measured)]
        sigma = np.hypot(self.relative * self.measured, self.floor)
        scale = self.relative / self.floor
        pull = (np.arcsinh(scale * model) - np.arcsinh(scale * self.measured)) / self.relative - 0.5 * self.relative**2 * self.measured / sigma
        return -0.5 * (pull**2 + np.log(2.0 * np.pi * sigma**2)).sum()


def stretch_moves(posterior, start, steps, random):
    """Places of the walkers, steps x walkers x coordinates, and how often the model was asked."""
    u = start.copy()
    density = np.array([posterior.log_density(x) for x in u])
    asked = len(u)
    chain = []
    half = len(u) // 2
    for _ in range(steps):
        for moving, others in ((slice(0, half), slice(half, None)), (slice(half, None), slice(0, half))):
            place, pool = u[moving], u[others]
            z = ((STRETCH - 1.0) * random.random(half) + 1.0) ** 2 / STRETCH
            proposed = pool[random.integers(half, size=half)]
            proposed = proposed + z[:, None] * (place - proposed)
            new = np.array([posterior.log_density(x) for x in proposed])
            asked += half
            ratio = (u.shape[1] - 1) * np.log(z) + new - density[moving]
            accepted = np.log(random.random(half)) < ratio
            u[moving] = np.where(accepted[:, None], proposed, place)
            density[moving] = np.where(accepted, new, density[moving])
        chain.append(u.copy())
    return np.array(chain), asked


def autocorrelation_time(chain):
    """Of the worst coordinate, in steps: Sokal's window of five times itself over the mean of the walkers' autocorrelations."""
    worst = 0.0
    for k in range(chain.shape[2]):
        x = chain[:, :, k] - chain[:, :, k].mean()
        n = len(x)
        spectrum = np.fft.rfft(x, 2 * n, axis=0)
        correlation = np.fft.irfft((spectrum * spectrum.conj()).real, axis=0)[:n].mean(axis=1)
        time_of = 2.0 * np.cumsum(correlation / correlation[0]) - 1.0
        window = np.argmax(np.arange(n) >= 5.0 * time_of) or n - 1
        worst = max(worst, time_of[window])
    return worst


def main():
    sys.path.insert(0, sys.argv[1])
    import pavescape

    posterior = Posterior(pavescape, sys.argv[2])
    draws = rows_of(sys.argv[3])
    # The smooth surface stands for most full runs, hence the tolerance.
    some = draws[:: max(1, len(draws) // RUNS)]
    points = [np.array([float(row[name]) for name in posterior.study.parameters]) for row in some]
    apart = [posterior.log_density(posterior.unit(p)) - float(row["log_likelihood"]) for p, row in zip(points, some)]
    assert min(map(abs, apart)) < 1e-6 and max(map(abs, apart)) < 0.2, f"densities differ by {max(map(abs, apart))}"
    begin = time.process_time()
    for p in points:
        posterior.study.residual_jacobian(p)
    run = (time.process_time() - begin) / len(points)
    random = np.random.default_rng(1)
    begin = time.process_time()
    chosen = random.choice(len(points), WALKERS, replace=False)
    chain, asked = stretch_moves(posterior, np.array([posterior.unit(points[i]) for i in chosen]), int(sys.argv[4]), random)
    seconds = time.process_time() - begin
    length = autocorrelation_time(chain)
    print(json.dumps({"run_with_derivatives_s": run, "density_differs_by": max(map(abs, apart)), "runs": asked, "seconds": seconds,
                      "autocorrelation_steps": length, "effective": chain.shape[0] * chain.shape[1] / length}))


if __name__ == "__main__":
    main()
