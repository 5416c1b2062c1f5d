"""Variables and channels of the states of a direct simulation.

FORMAT.md defines the channels, from which a table makes the variables.
"""

from collections.abc import Sequence

import numpy as np

from sampler.formats.channels import CHANNELS, STATE, WORKS, to_channels
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import Simulation

#: Least distance of an energy share from 0 and 1, which single precision can resolve. A sphere that
#: meets the wall head-on does not turn, so its share would be 0.
_LEAST_DISTANCE_FROM_ENDS = 1e-6

#: Largest number of single precision below 1, and a number close to 0, for shares that a table
#: stores as they are. A sphere that meets an elastic wall head-on keeps its whole energy, a share
#: of 1.
_BELOW_ONE = 1.0 - 2.0**-24
_ABOVE_ZERO = 2.0**-100

#: Ranges to which channels are clipped.
_CHANNEL_RANGES = {
    "v": (_ABOVE_ZERO, _BELOW_ONE),
    "u_hat": (-_BELOW_ONE, _BELOW_ONE),
    "w_hat": (-_BELOW_ONE, _BELOW_ONE),
    "energy_hat": (_LEAST_DISTANCE_FROM_ENDS, 1.0 - _LEAST_DISTANCE_FROM_ENDS),
    "normal_hat": (_ABOVE_ZERO, _BELOW_ONE),
}

#: Largest growth of the energy by rounding.
_ROUNDING = 1e-9


def simulated_variables(simulation: Simulation, variables: Sequence[str]) -> FloatArray:
    """Compute variables of `sampler.formats.channels.VARIABLES`, shape (n, len(variables)).

    Rotational energy and works are over the kinetic energy before the impact.
    """
    return np.column_stack([_variable(simulation, name) for name in variables])


def simulated_channels(
    simulation: Simulation, channels: Sequence[str], rng: np.random.Generator
) -> FloatArray:
    """Compute channels of `sampler.formats.channels.CHANNELS`, shape (n, len(channels)).

    The numbers of collisions N are spread over [N, N + 1) by ``rng``.
    """
    state = _with_less_energy(simulation.state)
    columns = dict(zip(CHANNELS, to_channels(state).T, strict=False))
    if "energy_hat" in channels:
        moving = np.square(state[:, :3]).sum(axis=1)
        columns["energy_hat"] = simulation.energy[:, 1] / (1.0 - moving)
    if "normal_hat" in channels:
        columns |= _shares_after_works(simulation)
    for name in columns.keys() & _CHANNEL_RANGES.keys():
        columns[name] = np.clip(columns[name], *_CHANNEL_RANGES[name])
    if "collisions" in channels:
        # away from both ends of [N, N + 1), to which single precision would round
        columns["collisions"] = simulation.collisions + rng.uniform(0.01, 0.99, len(state))
    return np.column_stack([columns[name] for name in channels])


def _with_less_energy(state: FloatArray) -> FloatArray:
    """Scale states whose translational energy rounds to 1 or above to just below it."""
    energy = np.square(state[:, :3]).sum(axis=1)
    elastic = (energy > _BELOW_ONE) & (energy <= 1.0 + _ROUNDING)
    state = state.copy()
    state[elastic, :3] *= np.sqrt(_BELOW_ONE / energy[elastic])[:, None]
    return state


def _shares_after_works(simulation: Simulation) -> dict[str, FloatArray]:
    """Compute the channels that differ in a table with works, as shares of the remaining energy.

    The remaining energy is summed from its parts, so that nothing cancels.
    """
    u, w = simulation.state[:, 0], simulation.state[:, 2]
    rotation, (normal, shear) = simulation.energy[:, 1], simulation.work.T
    last = rotation + shear
    after_u = last + w * w
    after_normal = after_u + u * u
    return {
        "normal_hat": np.cbrt(np.sqrt(_share(normal, after_normal + normal))),
        "u_hat": _share(u, np.sqrt(after_normal)),
        "w_hat": _share(w, np.sqrt(after_u)),
        "energy_hat": _share(rotation, last),
    }


def _share(part: FloatArray, whole: FloatArray) -> FloatArray:
    """Divide a part by the whole; 0 where the whole is rounding."""
    some = whole > _ROUNDING
    return np.where(some, part / np.where(some, whole, 1.0), 0.0)


def _variable(simulation: Simulation, name: str) -> FloatArray:
    if name == "rotational_energy":
        return simulation.energy[:, 1]
    if name == "collisions":
        return simulation.collisions.astype(np.float64)
    if name in WORKS:
        return simulation.work[:, WORKS.index(name)]
    return simulation.state[:, STATE.index(name)]
