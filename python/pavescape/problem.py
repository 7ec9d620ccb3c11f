"""A Python function as the model: parameters, readings, and the analyses of a study."""
from __future__ import annotations

import csv
import dataclasses
import hashlib
import io
import json
import math
import pickle
import re
import traceback
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from . import _pavescape
from .study import Analyses
from .workers import Workers

# Of the readings, besides value and sigma.
_places = ("name", "load", "quantity", "x_mm", "y_mm", "depth_mm", "gauge_mm", "time_ms", "unit")

_most_processes = 1024


@dataclasses.dataclass(frozen=True)
class Parameter:
    """A number that is sought.

    name; low, high: its range; start: a value to begin with (None: the middle); scale: "linear" or "log"; prior: (mean, sd) of a normal prior on
    the scale, with "log" the median and the sd of the natural logarithm (None: uniform).
    """

    name: str
    low: float
    high: float
    start: float | None = None
    scale: str = "linear"
    prior: tuple[float, float] | None = None


@dataclasses.dataclass(frozen=True)
class Effect:
    """A switch of the function that a fit does not seek: what `diagnose` may find that the model lacks.

    name: in words; null: its value where there is no such effect; typical: another that matters; low, high: its range.
    """

    name: str
    null: float
    typical: float
    low: float
    high: float


def _effect(given: Any) -> Effect:
    if isinstance(given, Effect):
        return given
    if isinstance(given, Mapping):
        return Effect(**given)
    if isinstance(given, (tuple, list)) and len(given) == 5:
        return Effect(*given)
    raise ValueError(f"effects: {given!r}; allowed: (name, null, typical, low, high), a dictionary with these names, or an Effect")


def _parameter(given: Any) -> Parameter:
    if isinstance(given, Parameter):
        return given
    if isinstance(given, Mapping):
        return Parameter(**given)
    if isinstance(given, (tuple, list)) and len(given) in (3, 4):
        return Parameter(*given)
    raise ValueError(f"parameters: {given!r}; allowed: (name, low, high), (name, low, high, start), a dictionary with these names, or a Parameter")


def _readings(given: Any) -> dict[str, list[Any]]:
    """Columns of the readings."""
    if isinstance(given, tuple) and len(given) == 2:
        given = {"value": given[0], "sigma": given[1]}
    if not hasattr(given, "keys") or "value" not in given.keys() or "sigma" not in given.keys():
        raise ValueError("readings: allowed: (values, sigma), or a dictionary or DataFrame with the columns value and sigma, and any of "
                         + ", ".join(_places))
    unknown = [str(key) for key in given.keys() if key not in ("value", "sigma", *_places)]
    if unknown:
        raise ValueError(f"readings: unknown column {', '.join(unknown)}; allowed: value, sigma, {', '.join(_places)}")
    count = len(np.atleast_1d(np.asarray(given["value"], dtype=float)))
    columns = {}
    for key in given.keys():
        column = np.asarray(given[key]).tolist()
        columns[key] = column if isinstance(column, list) else [column] * count
        if len(columns[key]) != count:
            raise ValueError(f"readings: {key} has {len(columns[key])} entries; allowed: one, or {count} as value has")
    for key in ("value", "sigma"):
        columns[key] = [float(v) for v in columns[key]]
        if not all(map(math.isfinite, columns[key])):
            raise ValueError(f"readings: {key} holds a number that is not finite")
    columns.setdefault("name", [f"reading {i + 1}" for i in range(count)])
    return columns


def _csv(columns: Mapping[str, Sequence[Any]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*([repr(v) if isinstance(v, float) else v for v in column] for column in columns.values())))
    return text.getvalue()


def _toml(value: Any) -> str:
    return repr(float(value)) if isinstance(value, (int, float, np.number)) else json.dumps(str(value))


def _study_text(title: str, misfit: str, parameters: Iterable[Parameter], outputs: Iterable[tuple[str, str]], constraints: Iterable[str],
                effects: Iterable[Effect]) -> str:
    lines = ["# The model is a Python function.", "schema = 1", f"title = {_toml(title)}", "", "[data]", 'files = ["readings.csv"]',
             f"misfit = {_toml(misfit)}"]
    for p in parameters:
        lines += ["", "[[parameters]]", f"name = {_toml(p.name)}", f"min = {_toml(p.low)}", f"max = {_toml(p.high)}", f"scale = {_toml(p.scale)}"]
        if p.start is not None:
            lines.append(f"value = {_toml(p.start)}")
        if p.prior is not None:
            lines.append(f"prior = {{ mean = {_toml(p.prior[0])}, sd = {_toml(p.prior[1])} }}")
    for name, unit in outputs:
        lines += ["", "[[outputs]]", f"name = {_toml(name)}", f"unit = {_toml(unit)}"]
    for that in constraints:
        lines += ["", "[[constraints]]", f"that = {_toml(that)}"]
    for e in effects:
        value = re.sub(r"[^A-Za-z0-9_.-]+", "_", e.name)
        lines += ["", "[[effects]]", f"name = {_toml(e.name)}", f"parameter = {_toml('effect.' + value)}", f"null = {_toml(e.null)}",
                  f"typical = {_toml(e.typical)}", f"range = [{_toml(e.low)}, {_toml(e.high)}]"]
    return "\n".join(lines) + "\n"


def _stable(value: Any, seen: tuple[Any, ...] = ()) -> bytes:
    """The same bytes for the same code or value, in every process."""
    if any(value is other for other in seen):  # a function that names itself
        return b"again"
    within = (*seen, value)
    if value is None or isinstance(value, (str, bytes, int, float, complex)):
        return repr(value).encode() + b";"
    if isinstance(value, (tuple, list)):
        return b"(" + b"".join(_stable(item, within) for item in value) + b")"
    if isinstance(value, (set, frozenset)):
        return b"{" + b"".join(sorted(_stable(item, within) for item in value)) + b"}"
    if isinstance(value, types.CodeType):
        return value.co_code + _stable(value.co_names) + _stable(value.co_consts, within)
    if isinstance(value, types.FunctionType):
        cells = [cell.cell_contents for cell in value.__closure__ or () if cell != types.CellType()]
        return _stable([value.__code__, value.__defaults__, cells], within)
    try:
        return pickle.dumps(value, protocol=4)
    except Exception:  # what cannot be pickled is known by its type alone
        return repr(type(value)).encode()


def _reason(error: Exception) -> str:
    """An exception as an answer: its text and where it was raised."""
    words = "".join(traceback.format_exception_only(type(error), error)).strip()
    frames = traceback.extract_tb(error.__traceback__)
    if len(frames) > 1:
        words += f" ({frames[-1].filename.rsplit('/', 1)[-1]}, line {frames[-1].lineno})"
    return words + (f" ({_pavescape.passing_words})" if isinstance(error, (OSError, MemoryError)) else "")


class _Checked:
    """A function of the user, whose answers are arrays of one shape, or reasons as text."""

    def __init__(self, function: Callable[..., Any], shape: tuple[int, ...], names: list[str]) -> None:
        self.function, self.shape, self.names = function, shape, names

    def __call__(self, x: Any) -> Any:
        try:
            said = self.function(x)
            if isinstance(said, Mapping):
                missing = [name for name in self.names if name not in said]
                if missing:
                    return f"the function gave no {missing[0]!r}"
                said = [said[name] for name in self.names]
            values = np.ascontiguousarray(said, dtype=float)
        except Exception as error:
            return _reason(error)
        if [n for n in values.shape if n != 1] == [n for n in self.shape if n != 1]:  # columns, single numbers
            values = values.reshape(self.shape)
        if values.shape != self.shape:
            return f"the function gave an array of shape {values.shape}, not {self.shape}"
        wrong = np.argwhere(~np.isfinite(values))
        if len(wrong):
            where = f"the derivative of {self.names[wrong[0][0]]!r}" if len(self.shape) == 2 else repr(self.names[wrong[0][0]])
            return f"the function gave {values[tuple(wrong[0])]} for {where}"
        return values


class Problem(Analyses):
    """A Python function fitted to readings, with the analyses of Study.

    parameters: what is sought, a list of (name, low, high), (name, low, high, start), dictionaries, or Parameter.
    readings: (values, sigma), arrays of shape (readings,) (sigma may be one number), or a dictionary or DataFrame with the columns value and
        sigma, and any of name, load, quantity, x_mm, y_mm, depth_mm, gauge_mm, time_ms, unit. sigma is one standard deviation.
    function(x): of a float64 array of shape (parameters,), the readings and then the outputs: an array of shape (readings + outputs,), or a
        dictionary by name. An exception, or a number that is not finite, is a point without an answer: searches go around it.
    jacobian(x): their derivatives, shape (readings + outputs, parameters + effects); None: differences, in steps that the function's own noise
        needs.
    effects: what the function can do and the fit does not seek, for diagnose(): a list of (name, null, typical, low, high), dictionaries, or
        Effect. x then holds the parameters and after them the value of each effect, null where the model is without it.
    outputs: names, or (name, unit), of numbers that are predicted. constraints: texts as "slow >= fast". misfit: weighted, relative or log.

    processes: 0: the function is called here, with the interpreter's lock, one call at a time unless it gives the lock away, as NumPy's and SciPy's
        long work does. Else by so many processes of their own, started when they are needed, with the same answers; the function is pickled, and
        a script calls analyses from under `if __name__ == "__main__":`. As many work at once as the analysis has threads.

    Only analyses with out=FOLDER keep evaluations; a change of the function's own code, defaults or closure begins a new run there, a change of
    what it calls or reads does not. A problem can be pickled where its function can.
    """

    def __init__(self, parameters: Sequence[Any], readings: Any, function: Callable[..., Any], jacobian: Callable[..., Any] | None = None, *,
                 outputs: Sequence[Any] = (), constraints: Sequence[str] = (), misfit: str = "weighted", title: str = "problem",
                 effects: Sequence[Any] = (), processes: int = 0) -> None:
        own = [_parameter(p) for p in parameters]
        columns = _readings(readings)
        predicted = [(output, "-") if isinstance(output, str) else (output[0], output[1]) for output in outputs]
        names = [str(name) for name in columns["name"]] + [name for name, _ in predicted]
        switches = [_effect(e) for e in effects]
        if isinstance(processes, bool) or not isinstance(processes, int) or not 0 <= processes <= _most_processes:
            raise ValueError(f"processes = {processes!r}; allowed: whole numbers from 0 to {_most_processes}")
        self._state = (own, columns, function, jacobian, predicted, list(constraints), misfit, title, switches, processes)
        calls: list[Callable[[Any], Any]] = [_Checked(function, (len(names),), names)]
        if jacobian is not None:
            calls.append(_Checked(jacobian, (len(names), len(own) + len(switches)), names))
        if processes > 0:
            workers = Workers(calls, processes)
            calls = [workers.function(which) for which in range(len(calls))]
        identity = hashlib.sha256(_stable(function) + b"|" + _stable(jacobian)).hexdigest()
        self._core = _pavescape.Study.of_function(
            text=_study_text(title, misfit, own, predicted, constraints, switches), files={"readings.csv": _csv(columns)}, name="problem",
            function=calls[0], jacobian=calls[1] if jacobian is not None else None, identity=identity, parameters=len(own) + len(switches), responses=len(names))

    def __reduce__(self) -> Any:
        return _again, self._state


def _again(parameters: Any, readings: Any, function: Any, jacobian: Any, outputs: Any, constraints: Any, misfit: str, title: str,
           effects: Any, processes: int) -> Problem:
    return Problem(parameters, readings, function, jacobian, outputs=outputs, constraints=constraints, misfit=misfit, title=title, effects=effects,
                   processes=processes)
