"""Stand-ins for tables with a spin law, whose law is direct simulation itself: right and wrong.

They say what a test of spin laws must accept, and what it must refuse. A draw knows no orientation,
so that of a stand-in is uniform: nearly right at the impacts of chains, and wrong along chains.
"""

import numpy as np

from tablegen.simulation.direct import DirectModel
from tablegen.simulation.impact_chains import depart, occurring_impacts


class DirectTable:
    """Draws by direct simulation; what it does to the spin first makes it wrong."""

    def __init__(self, config, changed=lambda spin: spin, grain="own"):
        self.model, self.changed, self.grain = DirectModel(config), changed, grain
        self.columns = self.model.columns

    def sample(self, alpha1, speed, *, spin=None, grain=None, seed, index, hit, threads=None):
        """As `sampler.Table.sample`."""
        spin = np.zeros(3) if spin is None else self.changed(np.array(spin))
        keys = {"seed": seed, "index": index, "hit": hit, "threads": threads}
        own = self.grain if grain is None or self.grain == "fresh" else grain
        return self.model.sample(alpha1, speed, spin=spin, grain=own, **keys)


def turned(spin):
    return spin * [1.0, 1.0, -1.0]


def exchanged(spin):
    return spin[..., [1, 0, 2]]


#: Wrong laws by name: what becomes of a particle's spin, and whose grain it has.
WRONG = {
    "spin ignored": (lambda spin: 0.0 * spin, "own"),
    "sign of spin_z turned": (turned, "own"),
    "spin_x and spin_y exchanged": (exchanged, "own"),
    "spin scaled by 1.1": (lambda spin: 1.1 * spin, "own"),
    "fresh grains for kept ones": (lambda spin: spin, "fresh"),
}


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
