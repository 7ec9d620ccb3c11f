"""Studies, and the analyses that studies and problems share."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _pavescape
from .results import MapResult, Record, Result, SampleResult, result_of

Vector = NDArray[np.float64]
_default: dict[str, Any] = _pavescape.defaults


class Analyses:
    """What a Study and a Problem have in common.

    Analyses take the options of their command. out: the folder of the run, which continues where it was ended; empty: nothing is kept.
    threads: 0 for all. seed: fixes what is random. They raise ValueError for an argument out of its range, NoAnswer where there is none, and
    KeyboardInterrupt where Ctrl-C ended them after the evaluations that ran.

    time: seconds, or "30s", "10min", "2h", for the whole analysis; None: as long as it takes. What is not finished by then gives the best answer so
    far: a result whose `complete` is False, with `best` (None where no point has an answer) and `evaluations`. The same call with `out` goes on.
    It ends all analyses of the process.
    """

    _core: _pavescape.Study

    def __repr__(self) -> str:
        return repr(self._core)

    @property
    def title(self) -> str:
        """The title of the study."""
        return self._core.title

    @property
    def parameters(self) -> list[str]:
        """Names of the parameters, in their order."""
        return self._core.parameters

    @property
    def low(self) -> Vector:
        """Lower ends of the ranges, float64, shape (parameters,)."""
        return self._core.low

    @property
    def high(self) -> Vector:
        """Upper ends of the ranges, float64, shape (parameters,)."""
        return self._core.high

    @property
    def start(self) -> Vector:
        """The study's own values, float64, shape (parameters,)."""
        return self._core.start

    @property
    def responses(self) -> list[Record]:
        """Place and unit of every response: readings, then outputs."""
        return [Record(row) for row in self._core.responses]

    @property
    def measured(self) -> Vector:
        """Measured values, float64, shape (readings,), in the units of the responses."""
        return self._core.measured

    def forward(self, values: ArrayLike | None = None) -> Vector:
        """Responses at values, float64, shape (responses,), readings first, then outputs.

        values: of the parameters in their order and units, shape (parameters,); None: the study's own. Raises NoAnswer where the model has none.
        """
        return self._core.forward(values=values)

    def jacobian(self, values: ArrayLike | None = None) -> tuple[Vector, Vector]:
        """(responses, derivatives) by one run: float64, shapes (responses,) and (responses, parameters). values: as forward()."""
        return self._core.jacobian(values=values)

    def residuals(self, values: ArrayLike | None = None) -> Vector:
        """Residuals of the study's misfit, float64, shape (residuals,); their norm is the misfit.

        Loads that outputs alone need are not computed. values: as forward().
        """
        return self._core.residuals(values=values)

    def residual_jacobian(self, values: ArrayLike | None = None) -> Vector:
        """Derivatives of the residuals, float64, shape (residuals, parameters). values: as forward()."""
        return self._core.residual_jacobian(values=values)

    def residuals_and_jacobian(self, values: ArrayLike | None = None) -> tuple[Vector, Vector]:
        """(residuals, their derivatives) by one run: float64, shapes (residuals,) and (residuals, parameters). values: as forward()."""
        return self._core.residuals_and_jacobian(values=values)

    def fit(self, starts: int = _default["fit_starts"], explore: int = _default["fit_explore"], model: str = "full", joint_only: bool = False, out: str = "",
            threads: int = 0, seed: int = 1, method: str = _default["fit_method"], scheme: str = "multistart",
            model_error: float = _default["model_error"], start: Sequence[Mapping[str, float]] = (), from_: Sequence[str] = (),
            evaluations: int = _default["fit_evaluations"], time: float | str | None = None) -> Result:
        """The best parameters, and how well they are known: explore, then search from the best starts.

        starts: local searches. explore: points of the sample before them. model: full, reduced or auto. joint_only: no fits of single groups of
        readings. method: of the local search. scheme: multistart or paper. model_error: accepted of a reduced model [%].
        start: searches from these values too, {name: value} each. from_: searches from the lowest points of earlier runs (folders) or of CSV files too.
        evaluations: of each search, at most. time: of the whole analysis, as Analyses says.
        """
        begin = [",".join(f"{name}={float(value)!r}" for name, value in values.items()) for values in start]
        return result_of("fit", self._core.fit(starts=starts, explore=explore, model=model, joint_only=joint_only, out=os.fspath(out), threads=threads,
                                               seed=seed, method=method, scheme=scheme, model_error=model_error, start=begin,
                                               from_=[os.fspath(place) for place in from_], evaluations=evaluations, time=time))

    def map(self, design: str = "auto", points: int = 0, model: str = "full", out: str = "", threads: int = 0, seed: int = 1,
            model_error: float = _default["model_error"], time: float | str | None = None) -> MapResult:
        """The misfit over the box. design: auto, grid, sobol or adaptive. points: 0 for as many as usual. Else as fit()."""
        text, points_, misfit = self._core.map(design=design, points=points, model=model, out=os.fspath(out), threads=threads, seed=seed,
                                               model_error=model_error, time=time)
        return MapResult((result_of("map", text), points_, misfit))

    def unique(self, explore: int = _default["unique_explore"], verify: int = _default["unique_verify"], searches: int = _default["unique_searches"],
               model: str = "full", out: str = "", threads: int = 0, seed: int = 1, landscape: bool = False, posterior: bool = False,
               model_error: float = _default["model_error"], time: float | str | None = None) -> Result:
        """Is the answer the only one? Minima, flat directions, what the data accept of each parameter and output.

        explore: points of the sample. verify: searches that must find no new minimum. searches: at most. landscape: the profiled misfit over every
        pair. posterior: the posterior of each parameter beside its profile. Else as fit().
        """
        return result_of("unique", self._core.unique(explore=explore, verify=verify, searches=searches, model=model, out=os.fspath(out), threads=threads,
                                                     seed=seed, landscape=landscape, posterior=posterior, model_error=model_error, time=time))

    def sample(self, samples: int = _default["sample_samples"], confirm: int = _default["sample_confirm"], model: str = "", out: str = "", threads: int = 0,
               seed: int = 1, model_error: float = _default["model_error"], time: float | str | None = None) -> SampleResult:
        """The posterior. samples: draws. confirm: draws that the full model checks. model: empty: whichever is cheaper. Else as fit()."""
        text, draws, outputs, weights = self._core.sample(samples=samples, confirm=confirm, model=model, out=os.fspath(out), threads=threads, seed=seed,
                                                          model_error=model_error, time=time)
        return SampleResult((result_of("sample", text), draws, outputs, weights))

    def prior_check(self, samples: int = _default["sample_samples"], out: str = "", threads: int = 0, seed: int = 1,
                    time: float | str | None = None) -> Result:
        """Before any fit: what the prior predicts of each reading with its noise, and which it does not reach (`unreached`, `readings`).

        samples: points of the prior. Else as fit().
        """
        return result_of("sample-prior", self._core.prior_check(samples=samples, out=os.fspath(out), threads=threads, seed=seed, time=time))

    def sensitivity(self, parameters: Sequence[str] = (), range: float = _default["sensitivity_range"], points: int = _default["sensitivity_points"],
                    samples: int = _default["sensitivity_samples"], out: str = "", threads: int = 0, seed: int = 1) -> Result:
        """What governs each response: elasticities, curves, Sobol indices.

        parameters: of the curves; empty: those that are sought. range: of the curves, in percent of the value. points: of each curve. samples: of the
        indices, 0 for none. Else as fit().
        """
        return result_of("sensitivity", self._core.sensitivity(parameters=list(parameters), range=range, points=points, samples=samples, out=os.fspath(out),
                                                               threads=threads, seed=seed))

    def diagnose(self, explore: int = _default["diagnose_explore"], starts: int = _default["diagnose_starts"], bootstrap: int = _default["diagnose_bootstrap"],
                 without: Sequence[str] = (), model: str = "full", out: str = "", threads: int = 0, seed: int = 1,
                 model_error: float = _default["model_error"], time: float | str | None = None) -> Result:
        """What the model gets wrong, and why. bootstrap: simulated data sets. without: effects that are left out. model: full or auto. Else as fit()."""
        return result_of("diagnose", self._core.diagnose(explore=explore, starts=starts, bootstrap=bootstrap, without=list(without), model=model,
                                                         out=os.fspath(out), threads=threads, seed=seed, model_error=model_error, time=time))

    def compare(self, layer: str = "", laws: Sequence[str] = (), explore: int = _default["unique_explore"], verify: int = _default["unique_verify"],
                out: str = "", threads: int = 0, seed: int = 1, evidence: bool = False, others: Sequence[Analyses] = ()) -> Result:
        """Which law, or which study, do the same readings prefer?

        layer: whose laws; empty: the one that depends on stress. laws: empty: all. others: studies or problems with the same readings, in place of
        laws. evidence: sample each posterior too. Else as unique().
        """
        return result_of("compare", self._core.compare(others=[other._core for other in others], layer=layer, laws=list(laws), explore=explore,
                                                       verify=verify, out=os.fspath(out), threads=threads, seed=seed, evidence=evidence))


class Study(Analyses):
    """A study file with its measurements: forward model, misfit, and the analyses of the command line.

    Study(file) raises ValueError for what is wrong in it, with file, line and key. A study can be copied and pickled: the copy holds the files as
    they were read.
    """

    def __init__(self, file: str | os.PathLike[str]) -> None:
        self._core = _pavescape.Study(file=os.fspath(file))

    @classmethod
    def from_text(cls, text: str, files: Mapping[str, str] | None = None, name: str = "study.toml") -> Study:
        """A study in memory: its text, and the texts of its data files by the names that it calls them. name: what messages call it."""
        study = cls.__new__(cls)
        study._core = _pavescape.Study.from_text(text=text, files=dict(files or {}), name=name)
        return study

    def design(self, reliability: float = _default["design_reliability"], years: float = _default["design_years"],
               explore: int = _default["unique_explore"], verify: int = _default["unique_verify"], model: str = "full", out: str = "", threads: int = 0,
               seed: int = 1, model_error: float = _default["model_error"]) -> Result:
        """Remaining life and overlay, with ranges: the [[criteria]] of the study.

        reliability: that an overlay lasts, over what the data accept [%]. years: of traffic, where a criterion states none. model: full or auto.
        explore, verify: as unique(). Else as fit().
        """
        return result_of("design", self._core.design(reliability=reliability, years=years, explore=explore, verify=verify, model=model,
                                                     out=os.fspath(out), threads=threads, seed=seed, model_error=model_error))
