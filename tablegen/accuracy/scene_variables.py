"""Variables of the state and channels, of a direct simulation."""

from collections.abc import Sequence

import numpy as np

from sampler.formats.channels import CHANNELS, STATE, WORKS, to_channels
from tablegen.model.float_array import FloatArray
from tablegen.simulate import Simulation

#: Shares of an energy are kept this far inside (0, 1), where single precision can tell them from
#: the ends: a sphere that meets the wall head-on does not turn at all.
_INSIDE = 1e-6

#: The same for shares that a table stores as they are, down to the last number of single precision
#: below 1: a sphere that meets an elastic wall head-on keeps all of its energy.
_BELOW_ONE = 1.0 - 2.0**-24
_ABOVE_ZERO = 2.0**-100

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
    first = to_channels(state)
    columns = dict(zip(CHANNELS, first.T, strict=False))
    for name in ("v", "u_hat", "w_hat"):
        least = _ABOVE_ZERO if name == "v" else -_BELOW_ONE
        columns[name] = np.clip(columns[name], least, _BELOW_ONE)
    if "energy_hat" in channels:
        moving = np.square(state[:, :3]).sum(axis=1)
        share = simulation.energy[:, 1] / (1.0 - moving)
        columns["energy_hat"] = np.clip(share, _INSIDE, 1.0 - _INSIDE)
    if "normal_hat" in channels:
        columns["normal_hat"] = np.clip(_normal_hat(simulation), _ABOVE_ZERO, _BELOW_ONE)
    if "collisions" in channels:
        # kept off both ends, which single precision would round to
        columns["collisions"] = simulation.collisions + rng.uniform(0.01, 0.99, len(first))
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


def _normal_hat(simulation: Simulation) -> FloatArray:
    """Fourth root of the share of the normal impulses in what was lost; 1 where nothing was."""
    lost = simulation.work.sum(axis=1)
    loses = lost > 0.0
    share = simulation.work[:, 0] / np.where(loses, lost, 1.0)
    return np.sqrt(np.sqrt(np.where(loses, share, 1.0)))


def _variable(simulation: Simulation, name: str) -> FloatArray:
    if name == "rotational_energy":
        return simulation.energy[:, 1]
    if name == "collisions":
        return simulation.collisions.astype(np.float64)
    if name in WORKS:
        return simulation.work[:, WORKS.index(name)]
    return simulation.state[:, STATE.index(name)]
