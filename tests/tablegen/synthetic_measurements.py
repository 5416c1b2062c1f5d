"""Measurements made by direct simulation of a known pair, with the chance of a real experiment."""

import numpy as np

from tablegen.measured.measurements import QUANTITIES, Measurements, Moments
from tablegen.simulation.simulate import simulate


def measured_from(config, alpha_deg, count, seed, spreads=True, stated=True, speed=100.0):
    """Means and spreads of e_n and e_t over ``count`` particles drawn from the pair.

    Parameters
    ----------
    spreads : bool
        Whether spreads are measured, and not means alone.
    stated : bool
        Whether the count is stated.
    """
    moments = {q: Moments(*np.full((2, len(alpha_deg)), np.nan)) for q in QUANTITIES}
    for row, degrees in enumerate(alpha_deg):
        alpha = np.radians(degrees)
        state = simulate(config, alpha, speed, count, seed=seed, stream=row).state
        for name, values in (("e_n", state[:, 1] / np.sin(alpha)), ("e_t", state[:, 0])):
            if name == "e_t" and degrees == 90.0:
                continue
            values = values / np.cos(alpha) if name == "e_t" else values
            moments[name].mean[row] = values.mean()
            if spreads:
                moments[name].std[row] = values.std(ddof=1)
    n = len(alpha_deg)
    return Measurements(
        name="synthetic",
        alpha_deg=np.array(alpha_deg, dtype=np.float64),
        speed=np.full(n, speed),
        moments=moments,
        count=np.full(n, float(count) if stated else np.nan),
        source=("simulated",) * n,
        remarks=("",) * n,
        about={},
    )
