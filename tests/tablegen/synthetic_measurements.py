"""Measurements made by direct simulation of a known pair."""

from dataclasses import replace

import numpy as np

from tablegen import load_config
from tablegen.measured.measurements import QUANTITIES, Measurements, Moments
from tablegen.simulation.simulate import simulate

SOURCE = {"source": "chosen for a test"}


def small_pair(value=0.5, friction=0.4, **changes):
    """Ellipsoids of one form under constant laws."""
    laws = {
        "restitution": {"law": "constant", "value": value, **SOURCE},
        "resistance": {"law": "constant", "value": friction, **SOURCE},
    }
    weights = {"ellipsoid": 1.0, "prism": 0.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
    population = {"shapes": weights, "aspect": {"distribution": "fixed", "values": [0.9, 0.8]}}
    tree = {"name": "small", "spin": False, "pair": laws, "population": population}
    tree["domain"] = {"extrapolate": True}
    return load_config("corundum-steel").with_changes(tree | changes)


def some_rows(data, rows):
    at = np.asarray(rows)
    arrays = {field: getattr(data, field)[at] for field in ("alpha_deg", "speed", "count")}
    texts = {field: tuple(getattr(data, field)[k] for k in at) for field in ("source", "remarks")}
    moments = {name: Moments(m.mean[at], m.std[at]) for name, m in data.moments.items()}
    return replace(data, moments=moments, **arrays, **texts)


def measured_from(config, alpha_deg, count, seed, spreads=True):
    """Means, and spreads if wanted, of e_n and e_t over ``count`` particles of the pair."""
    moments = {q: Moments(*np.full((2, len(alpha_deg)), np.nan)) for q in QUANTITIES}
    for row, degrees in enumerate(alpha_deg):
        alpha = np.radians(degrees)
        state = simulate(config, alpha, 100.0, count, seed=seed, stream=row).state
        ratios = {"e_n": state[:, 1] / np.sin(alpha)}
        if degrees < 90.0:
            ratios["e_t"] = state[:, 0] / np.cos(alpha)
        for name, values in ratios.items():
            moments[name].mean[row] = values.mean()
            if spreads:
                moments[name].std[row] = values.std(ddof=1)
    n = len(alpha_deg)
    return Measurements(
        name="synthetic",
        alpha_deg=np.array(alpha_deg, dtype=np.float64),
        speed=np.full(n, 100.0),
        moments=moments,
        count=np.full(n, float(count)),
        source=("simulated",) * n,
        remarks=("",) * n,
        about={},
    )
