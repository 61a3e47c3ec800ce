"""Fit the film model that ``jkr export --nanite`` wrote to a curve of another film, in an installed nanite."""

import nanite
import numpy as np
from scipy.interpolate import CubicSpline

model = nanite.model.load_model_from_file("model_jkr_film.py", register=True)
table, load = np.loadtxt("other-dem.csv", delimiter=",", skiprows=1, usecols=(1, 2)).T
delta = np.linspace(-2e-6, 1e-6, 1001)
held = CubicSpline(np.sqrt(table - table[0]), load)(np.sqrt(np.clip(delta - table[0], 0, None)))
approach, retraction = (np.where(delta < begin, 0, held) for begin in (0, table[0]))
tip = 40e-9 - delta
curve = nanite.Indentation(
    {
        "tip position": np.concatenate([tip, tip[::-1]]),
        "force": np.concatenate([approach, retraction[::-1]]),
        "segment": np.repeat([0, 1], tip.size),
    },
    {"path": "other.tab", "enum": 0, "point count": 2 * tip.size},
)
for segment in (0, 1):
    curve.fit_model(model_key=model.model_key, segment=segment, weight_cp=0, params_initial=None)
    found = curve.fit_properties["params_fitted"]
    print(*(f"{name} = {found[name].value:.6g}" for name in ("E", "w", "contact_point")))
