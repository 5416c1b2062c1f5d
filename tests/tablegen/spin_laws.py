"""Impacts of chains and what direct simulation makes of them."""

import numpy as np

from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import depart, occurring_impacts


def chain_sample(config, most_spin_z=np.inf):
    """Impacts of chains, states and works after as many others, and a bound of KS distances.

    Of equal laws, a variable exceeds the bound with p = 0.001. Spins along z are smaller than
    ``most_spin_z``.
    """
    model, index = DirectModel(config), np.arange(8000, dtype=np.uint64)
    both = (occurring_impacts(config, model, 3, index + np.uint64(k)) for k in (0, 8000))
    impacts, others = (some.of(some.spin[:, 2] < most_spin_z) for some in both)
    left = depart(model, others, 3)
    sizes = 1.0 / len(others.index) + 1.0 / len(impacts.index)
    bound = np.sqrt(0.5 * np.log(2.0 / 1e-3) * sizes)
    return impacts, np.hstack([left.states, left.works]), bound
