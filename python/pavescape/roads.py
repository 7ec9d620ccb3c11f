"""Roads of FWD drops, and figures and pages of the folders of runs: the commands survey, road, noise, plot and report."""
from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from . import _pavescape
from .results import Result, result_of

# That leave a result in a folder.
_analyses = ["map", "fit", "sensitivity", "unique", "sample", "design", "diagnose", "compare", "survey", "road"]


def names_of(files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[str]:
    """A path or several as a list of texts."""
    return [os.fspath(files)] if isinstance(files, (str, os.PathLike)) else [os.fspath(file) for file in files]


def survey(files: str | Sequence[str], study: str = "", columns: str = "", layers: str = "", out: str = "", threads: int = 0, seed: int = 1) -> Result:
    """Each station of a road by itself, as the command `survey`.

    files: of FWD drops. study: a file of which the parameters are fitted at every station; empty: no back-calculation. columns: what the
    columns of a spreadsheet mean, as --columns. layers: a table of thicknesses by chainage, as --layers. out: the folder of the run, which
    continues; empty: nothing is kept. threads: 0 for all.
    Raises ValueError for what is wrong in a file, NoAnswer, KeyboardInterrupt.
    """
    return result_of("survey", _pavescape.survey(files=names_of(files), study=os.fspath(study), columns=columns, layers=os.fspath(layers), out=os.fspath(out),
                                                threads=threads, seed=seed))


def road(files: str | Sequence[str], study: str, columns: str = "", layers: str = "", withhold: str = "", diagnose: bool = False,
         out: str = "", threads: int = 0, seed: int = 1) -> Result:
    """The stations of a road as one experiment, as the command `road`.

    study: a file whose parameters state their level. withhold: a load ("40kN", "566kPa") that is predicted, not fitted. diagnose: look for
    what the model lacks at all stations. Else as survey().
    """
    return result_of("road", _pavescape.road(files=names_of(files), study=os.fspath(study), columns=columns, layers=os.fspath(layers),
                                             withhold=withhold, diagnose=diagnose,
                                             out=os.fspath(out), threads=threads, seed=seed))


def noise(files: str | Sequence[str], columns: str = "") -> Result:
    """The noise of FWD readings, from repeated drops, as the command `noise`."""
    return result_of("noise", _pavescape.noise(files=names_of(files), columns=columns))


def _folder_of(run: Any) -> str:
    folder = run if isinstance(run, (str, os.PathLike)) else run["run"]
    if not os.fspath(folder):
        raise ValueError("run: this result was not kept; allowed: a folder, or a result of an analysis with out=FOLDER")
    return os.fspath(folder)


def plot(run: Any, figures: str | Sequence[str] = (), format: str = "svg", out: str = "") -> list[str]:
    """Figures of a run as files, as the command `plot`; returns their paths.

    run: the folder of a run, or a result that was kept in one. figures: names; empty: all. format: svg, pdf or png. out: the folder of the
    files; empty: figures/ in the run's.
    """
    folder = _folder_of(run)
    return _pavescape.draw(folder=folder, results="", analyses=_analyses, names=names_of(figures), format=format,
                           out=os.fspath(out) or os.path.join(folder, "figures"))


def report(run: Any, out: str = "") -> str:
    """One HTML page of a run, as the command `report`; returns its path.

    run: the folder of a run, or a result that was kept in one. out: the file; empty: report.html in the folder.
    """
    return _pavescape.write_page(folder=_folder_of(run), analyses=_analyses, out=os.fspath(out))
