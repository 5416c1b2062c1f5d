"""Variables of the state and channels, of a direct simulation."""

from collections.abc import Sequence

import numpy as np

from sampler.formats.channels import CHANNELS, STATE, to_channels
from tablegen.model.float_array import FloatArray
from tablegen.simulate import Simulation

#: Shares of an energy are kept this far inside (0, 1), where single precision can tell them from
#: the ends: a sphere that meets the wall head-on does not turn at all.
_INSIDE = 1e-6


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
        Rotational energy over the kinetic energy before the impact; collisions as numbers.
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
    first = to_channels(simulation.state)
    columns = dict(zip(CHANNELS, first.T, strict=False))
    if "energy_hat" in channels:
        moving = np.square(simulation.state[:, :3]).sum(axis=1)
        share = simulation.energy[:, 1] / (1.0 - moving)
        columns["energy_hat"] = np.clip(share, _INSIDE, 1.0 - _INSIDE)
    if "collisions" in channels:
        # kept off both ends, which single precision would round to
        columns["collisions"] = simulation.collisions + rng.uniform(0.01, 0.99, len(first))
    return np.column_stack([columns[name] for name in channels])


def _variable(simulation: Simulation, name: str) -> FloatArray:
    if name == "rotational_energy":
        return simulation.energy[:, 1]
    if name == "collisions":
        return simulation.collisions.astype(np.float64)
    return simulation.state[:, STATE.index(name)]
