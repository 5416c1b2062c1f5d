"""Variables of a state, and channels: the numbers in which a table describes one rebound.

A table does not store u, v and w. It shares out the energy before the impact among the variables,
one after another ("stick-breaking"), and stores the share that each takes of what is left. So no
draw has more energy than the particle brought, whatever a fit or an interpolation does to the
channels. tables/FORMAT.md has the formulae.

The channels of a plane flow (v, u, omega_z) come first, then the three that change sign under
reflection in the impact plane. The work of the normal impulses comes after v and before u, because
it depends most on these two. At grazing incidence it falls with the square or the cube of the
angle, so its sixth root is stored, which is nearly linear between nodes.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from sampler.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Variables of a state, in the order of every public array and file.
VARIABLES = (
    "u",
    "v",
    "w",
    "omega_x",
    "omega_y",
    "omega_z",
    "rotational_energy",
    "collisions",
    "work_normal",
    "work_shear",
)

#: Variables that every table has unless its scene says otherwise: u to omega_z.
STATE = VARIABLES[:6]

#: Channels; a table holds some of them.
CHANNELS = (
    "v",
    "u_hat",
    "omega_z",
    "w_hat",
    "omega_x",
    "omega_y",
    "energy_hat",
    "collisions",
    "normal_hat",
)

#: Most channels, and most variables, of one table: rows of a factor that a draw works out side by
#: side, and places for names in a binary table.
MOST_NAMES = 8

#: Energies that the impulses take, over the kinetic energy before the impact.
WORKS = ("work_normal", "work_shear")

#: Channels that change sign under reflection in the impact plane.
MIRRORED = ("w_hat", "omega_x", "omega_y")
FIRST_MIRRORED = CHANNELS.index("w_hat")
END_MIRRORED = CHANNELS.index("omega_y") + 1

#: Open intervals outside of which a channel would be unphysical.
RANGES = {
    "v": (0.0, 1.0),
    "u_hat": (-1.0, 1.0),
    "w_hat": (-1.0, 1.0),
    "energy_hat": (0.0, 1.0),
    "normal_hat": (0.0, 1.0),
}

_NEEDS = {
    "u": ("v", "u_hat"),
    "v": ("v",),
    "w": ("v", "u_hat", "w_hat"),
    "omega_x": ("omega_x",),
    "omega_y": ("omega_y",),
    "omega_z": ("omega_z",),
    "rotational_energy": ("v", "u_hat", "w_hat", "energy_hat"),
    "collisions": ("collisions",),
    "work_normal": ("v", "normal_hat"),
    "work_shear": ("v", "u_hat", "w_hat", "energy_hat", "normal_hat"),
}


def channels_for(variables: Iterable[str]) -> tuple[str, ...]:
    """List the channels from which variables of a state are made, in the order `CHANNELS`."""
    needed = {channel for variable in variables for channel in _NEEDS[variable]}
    return tuple(channel for channel in CHANNELS if channel in needed)


def to_channels(state: "NDArray[np.float64]") -> "NDArray[np.float64]":
    """Compute the channels of rebound states, the inverse of what a draw does last.

    Parameters
    ----------
    state : float64 array, shape (n, 6)
        u, v, w over V and omega_x, omega_y, omega_z times a/V.

    Returns
    -------
    float64 array, shape (n, 6)
        The first six `CHANNELS`, dimensionless.

    Raises
    ------
    InputError
        If a state does not leave the wall (v <= 0) or carries all of the translational energy
        or more (u^2 + v^2 + w^2 >= 1), for which the channels are not defined.
    """
    # here, because help pages show the names above and need no numpy
    import numpy as np

    state = np.asarray(state, dtype=np.float64)
    if state.ndim != 2 or state.shape[1] != len(STATE):
        raise InputError("state", f"shape {state.shape}", "(n, 6)")
    u, v, w = state[:, 0], state[:, 1], state[:, 2]
    energy = u * u + v * v + w * w
    # Negated so that NaN is refused as well.
    refused = ~((v > 0.0) & (energy < 1.0))
    if refused.any():
        k = int(refused.argmax())
        given = f"v = {v[k]:g}, u^2 + v^2 + w^2 = {energy[k]:.17g}"
        raise InputError("state", given, "v > 0 and a sum below 1", row=k)
    rest = (1.0 - v) * (1.0 + v)
    u_hat = u / np.sqrt(rest)
    w_hat = w / np.sqrt(rest - u * u)
    return np.column_stack((v, u_hat, state[:, 5], w_hat, state[:, 3], state[:, 4]))


def has_works(variables: Iterable[str]) -> bool:
    """Tell whether the work of the impulses is among some variables."""
    return not set(WORKS).isdisjoint(variables)
