"""Results as objects: dictionaries equal to the JSON of the commands, with attributes, tables and figures."""
from __future__ import annotations

import json
import pathlib
import tempfile
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _pavescape


class Record(dict):
    """A dictionary whose keys are attributes too: record["chi2"] is record.chi2. Names that a dictionary has, as `values`, are left to it."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name!r}; it has {', '.join(map(str, self))}") from None

    def __dir__(self) -> Iterable[str]:
        return sorted({*super().__dir__(), *(key for key in self if isinstance(key, str))})


def record_of(text: str) -> Record:
    """JSON text as nested records."""
    return json.loads(text, object_hook=Record)


class Figure:
    """A figure as SVG text; a notebook shows it.

    Attributes: name (of the figure, as `plot` of the command line calls it), svg (its text).
    """

    def __init__(self, name: str, svg: str) -> None:
        self.name = name
        self.svg = svg

    def save(self, file: str) -> str:
        """Write the SVG file; returns its path."""
        pathlib.Path(file).write_text(self.svg, encoding="utf-8")
        return file

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<pavescape.Figure {self.name}: {len(self.svg)} bytes of SVG>"


def _need(package: str, what: str) -> Any:
    try:
        return __import__(package)
    except ImportError:
        raise ImportError(f"{what} needs the package {package}, which is not installed: pip install {package}") from None


def draw(kind: str, record: Record, figure: str | None) -> Figure:
    """One figure of a result, by gnuplot."""
    results = json.dumps({kind: record})
    name = figure or next((own for own in _first.get(kind, ()) if own in _pavescape.figures(results)), None)
    if name is None:
        known = _pavescape.figures(results)
        if not known:
            raise ValueError(f"{kind} has no figures; allowed: the result of fit, unique, sample, sensitivity, compare, diagnose, survey or road")
        name = known[0]
    with tempfile.TemporaryDirectory(prefix="pavescape-") as folder:
        file, *_ = _pavescape.draw(folder="", results=results, analyses=[], names=[name], format="svg", out=folder)
        return Figure(name, pathlib.Path(file).read_text(encoding="utf-8"))


# The figure that answers the question of an analysis, where the user names none.
_first = {"fit": ("fit",), "unique": ("landscape", "profiles"), "sample": ("posterior",)}

# The list of records that to_dataframe() and table() take where none is named.
_tables = {"unique": "profiles", "diagnose": "hypotheses", "compare": "laws", "survey": "stations", "road": "stations", "design": "criteria",
           "sensitivity": "responses", "sample-prior": "readings", "noise": "sensors"}


def _columns(rows: list[dict[str, Any]]) -> dict[str, list[Any]]:
    names: dict[str, None] = {}
    for row in rows:
        names.update(dict.fromkeys(row))
    return {name: [row.get(name) for row in rows] for name in names}


class Result(Record):
    """The answer of an analysis: a dictionary equal to what the command prints with --json.

    Every key is an attribute (result.verdict, result.best.parameters). repr() is the short answer.
    Attributes: kind (the name of the analysis), chi2, p_value (of the fit), short (the short answer, as text).
    """

    kind = ""

    @property
    def _of_fit(self) -> dict[str, Any]:
        parts = (self, *(self.get(key) for key in ("noise", "acceptance", "baseline")))
        return next((part for part in parts if isinstance(part, dict) and "chi2" in part), {})

    @property
    def chi2(self) -> float | None:
        """The sum of squared residuals in units of the noise, at the best set; None where no noise is stated or nothing is fitted."""
        return self._of_fit.get("chi2")

    @property
    def p_value(self) -> float | None:
        """The probability of a chi2 as large by the noise alone; None where no noise is stated."""
        return self._of_fit.get("p_value")

    @property
    def x(self) -> NDArray[np.float64]:
        """The best parameters, float64, shape (parameters,), in the order of the study."""
        best = self.get("best") or (self.get("minima") or [{}])[0]
        if "parameters" not in best:
            raise AttributeError(f"{self.kind} has no best parameters")
        return np.array(list(best["parameters"].values()), dtype=float)

    @property
    def short(self) -> str:
        """The short answer: the verdict, the best values, the two findings that matter most."""
        lines = [f"{self.kind} of \"{self['study']['title']}\"" if "study" in self else self.kind]
        findings = self.get("findings", [])
        verdict = self.get("answer") or next(iter(findings), None)
        if verdict is not None:
            lines.append(f"  {verdict}")
        best = self.get("best")
        if not self.get("complete", True):
            lines.append(f"  not finished after {self['time_s']:g} s: the best of {self['evaluations']} points so far")
            lines += [f"  {name} = {value:.5g}" for name, value in (best or {}).get("parameters", {}).items()]
        elif self.kind == "fit":
            for name, value in best["parameters"].items():
                error = best.get("std_error", {}).get(name)
                lines.append(f"  {name} = {value:.5g}" + (f" (standard error {error:.2g})" if error is not None else ""))
            if self.chi2 is not None:
                lines.append(f"  chi2 = {self.chi2:.4g}" + (f", p = {self.p_value:.2g}" if self.p_value is not None else ""))
        if self.kind == "unique":
            lines += [f"  {p['name']} = {p['best']:.5g}, accepted {_end(p['low'])} to {_end(p['high'])}" for p in self.get("profiles", [])]
        lines += [f"  {sentence}" for sentence in findings if sentence != verdict][:2]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return self.short

    def table(self, name: str | None = None) -> dict[str, list[Any]]:
        """A list of the result as columns: {column: values}.

        name: a key whose value is a list of records, as "responses", "minima", "outputs"; None: the one that answers the
        question (fit: its parameters; unique: profiles; diagnose: hypotheses; compare: laws; survey, road: stations).
        """
        if name is None and self.kind == "fit":
            best = self["best"]
            return {"name": list(best["parameters"]), "value": list(best["parameters"].values()),
                    "std_error": [best.get("std_error", {}).get(p) for p in best["parameters"]]}
        lists = [key for key, value in self.items() if isinstance(value, list) and value and all(isinstance(row, dict) for row in value)]
        wanted = name or _tables.get(self.kind, "")
        if wanted not in lists:
            if name is None and lists:
                wanted = lists[0]
            else:
                raise ValueError(f"table = {wanted!r}; allowed: {', '.join(lists) or 'none: this result has no lists'}")
        return _columns(self[wanted])

    def to_dataframe(self, name: str | None = None) -> Any:
        """table() as a pandas.DataFrame. Raises ImportError where pandas is not installed."""
        return _need("pandas", "to_dataframe()").DataFrame(self.table(name))

    def plot(self, figure: str | None = None, ax: Any = None) -> Any:
        """A figure of the result, as `pavescape plot` draws it.

        figure: its name ("fit", "residuals", "landscape", "profiles", "posterior", "candidates", ...); None: the one that answers the
        question. ax: matplotlib axes; then readings and best fit are drawn there, and ax is returned.
        Returns a Figure. Raises ValueError for a name that the result does not have, and where gnuplot is not installed.
        """
        if ax is not None:
            return self._on_axes(ax)
        return draw(self.kind, self, figure)

    def _on_axes(self, ax: Any) -> Any:
        rows = [row for row in self.get("responses", []) if isinstance(row, dict) and "measured" in row]
        if not rows:
            raise ValueError(f"{self.kind} has no readings with a best fit to draw on axes; without ax it draws {_pavescape.figures(json.dumps({self.kind: self}))}")
        at = np.arange(1, len(rows) + 1)
        ax.errorbar(at, [row["measured"] for row in rows], yerr=[row.get("sigma") or 0.0 for row in rows], fmt="o", label="measured")
        ax.plot(at, [row["value"] for row in rows], marker="x", linestyle="none", label="best fit")
        ax.set_xlabel("reading")
        ax.set_ylabel(rows[0]["unit"])
        ax.legend()
        return ax


def _end(value: float | None) -> str:
    return "-" if value is None else f"{value:.5g}"


def result_of(kind: str, text: str) -> Result:
    """The result of an analysis of its JSON text."""
    result = Result(record_of(text))
    result.__dict__["kind"] = kind
    return result


class _WithArrays(tuple):
    """A result with arrays: a tuple that unpacks into them, and the record's keys and attributes."""

    result: Result

    def __getitem__(self, key: Any) -> Any:
        return self.result[key] if isinstance(key, str) else super().__getitem__(key)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(super().__getitem__(0), name)

    def keys(self) -> Iterator[str]:
        """Keys of the result."""
        return iter(self.result.keys())

    def __repr__(self) -> str:
        return self.result.short


class MapResult(_WithArrays):
    """The misfit over the box: a Result (attributes, keys) with arrays; unpacks as (result, points, misfit)."""

    @property
    def result(self) -> Result:  # type: ignore[override]
        """The record, as the other analyses give it."""
        return tuple.__getitem__(self, 0)

    @property
    def points(self) -> NDArray[np.float64]:
        """Parameters of every point, float64, shape (points, parameters), in the units of the study."""
        return tuple.__getitem__(self, 1)

    @property
    def misfit(self) -> NDArray[np.float64]:
        """Misfit of every point, float64, shape (points,); not a number where the model has no answer."""
        return tuple.__getitem__(self, 2)

    def table(self, name: str | None = None) -> dict[str, Any]:
        """The points as columns, a parameter each, and misfit; name: a list of the result instead."""
        if name is not None:
            return self.result.table(name)
        return {**{p["name"]: self.points[:, k] for k, p in enumerate(self.result["parameters"])}, "misfit": self.misfit}

    def to_dataframe(self, name: str | None = None) -> Any:
        """table() as a pandas.DataFrame. Raises ImportError where pandas is not installed."""
        return _need("pandas", "to_dataframe()").DataFrame(self.table(name))


class SampleResult(_WithArrays):
    """A sample of the posterior: a Result (attributes, keys) with draws; unpacks as (result, draws, outputs, weights)."""

    @property
    def result(self) -> Result:  # type: ignore[override]
        """The record, as the other analyses give it."""
        return tuple.__getitem__(self, 0)

    @property
    def draws(self) -> NDArray[np.float64]:
        """Parameters of every draw, float64, shape (draws, parameters), in the units of the study."""
        return tuple.__getitem__(self, 1)

    @property
    def output_draws(self) -> NDArray[np.float64]:
        """Outputs of every draw, float64, shape (draws, outputs); not a number where they were not computed."""
        return tuple.__getitem__(self, 2)

    @property
    def weights(self) -> NDArray[np.float64]:
        """Weight of every draw, float64, shape (draws,)."""
        return tuple.__getitem__(self, 3)

    @property
    def _names(self) -> tuple[list[str], list[str]]:
        return [p["name"] for p in self.result["parameters"]], [o["name"] for o in self.result["outputs"]][:self.output_draws.shape[1]]

    def table(self, name: str | None = None) -> dict[str, Any]:
        """The draws as columns: a parameter each, an output each, and weight; name: a list of the result instead."""
        if name is not None:
            return self.result.table(name)
        parameters, outputs = self._names
        return {**{p: self.draws[:, k] for k, p in enumerate(parameters)}, **{o: self.output_draws[:, k] for k, o in enumerate(outputs)},
                "weight": self.weights}

    def to_dataframe(self, name: str | None = None) -> Any:
        """table() as a pandas.DataFrame. Raises ImportError where pandas is not installed."""
        return _need("pandas", "to_dataframe()").DataFrame(self.table(name))

    def equal_draws(self) -> NDArray[np.intp]:
        """Numbers of draws that weigh alike, as many as there are, intp, shape (draws,): systematic resampling from the middle of each part."""
        share = np.cumsum(self.weights) / np.sum(self.weights)
        n = len(self.weights)
        return np.minimum(np.searchsorted(share, (np.arange(n) + 0.5) / n), n - 1)

    def to_arviz(self) -> Any:
        """An arviz.InferenceData of equally weighted draws, one chain. Raises ImportError where arviz is not installed."""
        arviz = _need("arviz", "to_arviz()")
        parameters, outputs = self._names
        rows = self.equal_draws()
        return arviz.from_dict(posterior={p: self.draws[rows, k][None, :] for k, p in enumerate(parameters)},
                               posterior_predictive={o: self.output_draws[rows, k][None, :] for k, o in enumerate(outputs)} or None)

    def plot(self, figure: str | None = None, ax: Any = None, parameter: str | None = None) -> Any:
        """The posterior as `pavescape plot` draws it, a Figure; ax: matplotlib axes for a histogram of one parameter (None: the first)."""
        if ax is None:
            return self.result.plot(figure)
        parameters, _ = self._names
        name = parameter or parameters[0]
        if name not in parameters:
            raise ValueError(f"parameter = {name!r}; allowed: {', '.join(parameters)}")
        ax.hist(self.draws[:, parameters.index(name)], bins=40, weights=self.weights / np.sum(self.weights), histtype="step")
        ax.set_xlabel(name)
        ax.set_ylabel("share of the draws")
        return ax
