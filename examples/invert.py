"""A fit of a study by scipy, driven by the exact derivatives of the module: invert.py STUDY"""
import sys

import numpy as np
import pavescape
from scipy.optimize import least_squares

study = pavescape.Study(sys.argv[1])
answer = least_squares(study.residuals, study.start, jac=study.residual_jacobian, bounds=(study.low, study.high),
                       x_scale=study.high - study.low)
for name, value in zip(study.parameters, answer.x):
    print(f"{name} = {value:.6g}")
print(f"misfit {np.linalg.norm(answer.fun):.6g} after {answer.nfev} forward runs")
