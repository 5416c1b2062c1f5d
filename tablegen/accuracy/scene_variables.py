"""Variables of the state and channels, of a direct simulation."""

from collections.abc import Sequence

import numpy as np

from sampler.formats.channels import CHANNELS, STATE, WORKS, to_channels
from tablegen.model.float_array import FloatArray
from tablegen.simulation.simulate import Simulation

#: Shares of an energy are kept this far inside (0, 1), where single precision can tell them from
#: the ends: a sphere that meets the wall head-on does not turn at all.
_INSIDE = 1e-6

#: The same for shares that a table stores as they are, down to the last number of single precision
#: below 1: a sphere that meets an elastic wall head-on keeps all of its energy.
_BELOW_ONE = 1.0 - 2.0**-24
_ABOVE_ZERO = 2.0**-100

#: Ends between which channels are kept.
_KEPT = {
    "v": (_ABOVE_ZERO, _BELOW_ONE),
    "u_hat": (-_BELOW_ONE, _BELOW_ONE),
    "w_hat": (-_BELOW_ONE, _BELOW_ONE),
    "energy_hat": (_INSIDE, 1.0 - _INSIDE),
    "normal_hat": (_ABOVE_ZERO, _BELOW_ONE),
}

#: How far rounding may take the energy above what it was.
_ROUNDING = 1e-9


def simulated_variables(simulation: Simulation, variables: Sequence[str]) -> FloatArray:
    """Components of simulated states.

    Parameters
    ----------
    simulation : Simulation
    variables : sequence of str
        Some of `sampler.formats.channels.VARIABLES`.

    Returns
    -------
    (n, len(variables)) float64
        Rotational energy and works over the kinetic energy before the impact; collisions as
        numbers.
    """
    return np.column_stack([_variable(simulation, name) for name in variables])


def simulated_channels(
    simulation: Simulation, channels: Sequence[str], rng: np.random.Generator
) -> FloatArray:
    """Channels of simulated states.

    Parameters
    ----------
    simulation : Simulation
    channels : sequence of str
        Some of `sampler.formats.channels.CHANNELS`.
    rng : numpy Generator
        Spreads the numbers of collisions over [N, N + 1).

    Returns
    -------
    (n, len(channels)) float64
    """
    state = _with_less_energy(simulation.state)
    columns = dict(zip(CHANNELS, to_channels(state).T, strict=False))
    if "energy_hat" in channels:
        moving = np.square(state[:, :3]).sum(axis=1)
        columns["energy_hat"] = simulation.energy[:, 1] / (1.0 - moving)
    if "normal_hat" in channels:
        columns |= _shares_after_works(simulation)
    for name in columns.keys() & _KEPT.keys():
        columns[name] = np.clip(columns[name], *_KEPT[name])
    if "collisions" in channels:
        # kept off both ends, which single precision would round to
        columns["collisions"] = simulation.collisions + rng.uniform(0.01, 0.99, len(state))
    return np.column_stack([columns[name] for name in channels])


def _with_less_energy(state: FloatArray) -> FloatArray:
    """States of which none has kept all of its translational energy, but for rounding."""
    energy = np.square(state[:, :3]).sum(axis=1)
    elastic = (energy > _BELOW_ONE) & (energy <= 1.0 + _ROUNDING)
    if not elastic.any():
        return state
    state = state.copy()
    state[elastic, :3] *= np.sqrt(_BELOW_ONE / energy[elastic])[:, None]
    return state


def _shares_after_works(simulation: Simulation) -> dict[str, FloatArray]:
    """Channels that a table with works has otherwise, each a share of what is given out after it.

    What is left is added up from its parts, in which nothing cancels.
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
    """Part over the whole; 0 of nothing but rounding."""
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
