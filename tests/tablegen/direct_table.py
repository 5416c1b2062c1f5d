"""Stand-ins for tables with a spin law: direct simulation itself, and wrong versions of it.

They say what a test of spin laws must accept, and what it must refuse.
"""

import numpy as np

from tablegen.simulation.direct import DirectModel

#: Added to the hits, so that draws differ from those of a `DirectModel` with the same keys, while
#: grains are the same.
OTHER = np.uint32(2**20)


class DirectTable:
    """Draw by direct simulation, after a change of the spin that makes the law wrong, or none."""

    def __init__(self, config, changed=lambda omega, inertia: (omega, inertia), grain="own"):
        self.model, self.changed, self.grain = DirectModel(config), changed, grain
        self.columns, self.has_spin = self.model.columns, True

    def sample(self, alpha1, speed, *, spin=None, inertia=0.0, hit, **keys):
        """Draw states, with the arguments of `sampler.Table.sample`."""
        spin, inertia = self.changed(np.zeros(3) if spin is None else np.array(spin), inertia)
        keys |= {"hit": hit + OTHER, "grain": self.grain}
        return self.model.sample(alpha1, speed, spin=spin, inertia=inertia, **keys)

    def rebound(self, velocity, normal, half_size, *, omega, inertia, hit, **keys):
        """Compute rebounds, with the arguments of `sampler.Table.rebound`."""
        omega, inertia = self.changed(omega, inertia)
        keys |= {"hit": hit + OTHER, "grain": self.grain}
        if self.grain == "fresh":
            inertia = 0.0 * inertia
        return self.model.rebound(velocity, normal, half_size, omega=omega, inertia=inertia, **keys)


#: Wrong laws by name: what becomes of a particle's spin and inertia, and whose grain it has.
WRONG = {
    "spin ignored": (lambda omega, inertia: (0.0 * omega, inertia), "own"),
    "sign of omega turned": (lambda omega, inertia: (-omega, inertia), "own"),
    "spin scaled by 1.1": (lambda omega, inertia: (1.1 * omega, inertia), "own"),
    "inertia not known": (lambda omega, inertia: (omega, 0.0 * inertia), "own"),
    "fresh grains for kept ones": (lambda omega, inertia: (omega, inertia), "fresh"),
}
