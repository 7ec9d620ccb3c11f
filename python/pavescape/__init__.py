"""Calibration of stress-dependent pavement models, and of models of one's own: is the answer the only one, and can it be trusted?

    study = pavescape.Study("road.toml")            # a study file, as the command takes it
    answer = study.fit()
    print(answer)                                   # the short answer
    answer.best.parameters, answer.chi2             # what --json prints, as attributes and as a dictionary
    study.unique().plot()                           # a figure, in a notebook at once

A Python function is fitted by `Problem`, with the same analyses. docs/guide/python.md follows one deflection bowl from its file to
the posterior.
"""
from ._pavescape import NoAnswer, __version__
from .problem import Effect, Parameter, Problem
from .results import Figure, MapResult, Record, Result, SampleResult
from .roads import noise, plot, report, road, survey
from .study import Study

__all__ = ["Effect", "Figure", "MapResult", "NoAnswer", "Parameter", "Problem", "Record", "Result", "SampleResult", "Study", "__version__", "noise", "plot", "report",
           "road", "survey"]
