"""Tables of a few kilobytes with made-up numbers, one for each kind of scene."""

import numpy as np
from synthetic_table import AXES, make_contents, table_of

from sampler.formats.channels import CHANNELS, STATE, WORKS, channels_for

N_KNOTS, N_GRID, N_COMPONENTS, N_CLASSES = 9, 17, 4, 2


def scene(variables, alpha_deg=(20.0, 70.0), speed=(50.0, 120.0), seed=3, channels=()):
    """A table for some variables; channels beyond theirs only carry dependence."""
    rng = np.random.default_rng(seed)
    marginals = channels_for(variables)
    stored = [name for name in CHANNELS if name in {*marginals, *channels}]
    nodes = (len(alpha_deg), len(speed))
    low = {"v": 0.05, "energy_hat": 0.01, "collisions": 1.0, "normal_hat": 0.02}
    high = {"omega_x": 2.0, "omega_y": 2.0, "omega_z": 2.0, "collisions": 6.5}
    ends = [(low.get(name, -0.9), high.get(name, 0.9)) for name in marginals]
    quantiles = np.empty((*nodes, N_CLASSES, len(marginals), N_KNOTS))
    for k, (a, b) in enumerate(ends):
        inside = np.sort(rng.uniform(size=(*nodes, N_CLASSES, N_KNOTS)), axis=-1)
        quantiles[..., k, :] = a + (b - a) * inside
    shape = (*nodes, N_COMPONENTS)
    n = len(stored)
    factors = rng.integers(-2500, 2500, (*shape, n * (n + 1) // 2))
    diagonal = [row * (row + 3) // 2 for row in range(n)]
    factors[..., diagonal] = rng.integers(1500, 4000, (*shape, n))
    axes = [
        (np.array(x), np.array(x)[[0, -1]], np.linspace(0.0, np.sqrt(len(x) - 1.0), N_GRID) ** 2)
        for x in (alpha_deg, speed)
    ]
    return table_of(
        variables,
        stored,
        *axes,
        np.linspace(-3.0, 3.0, N_KNOTS),
        quantiles,
        first_of_class=np.broadcast_to([0, 1], (*nodes, N_CLASSES)),
        alias_probability=rng.integers(0, 65536, shape),
        alias_index=rng.integers(0, N_COMPONENTS, shape),
        reflection=rng.integers(0, 4097, shape),
        mean=rng.integers(-4000, 4000, (*shape, n)),
        cholesky=factors,
    )


def all_eight():
    """Every variable but the works, as many as a table can have; one node an axis of speed."""
    names = ("u", "v", "w", "omega_x", "omega_y", "omega_z", "rotational_energy", "collisions")
    return scene(names, speed=(120.0,))


def works():
    """The work of the impulses beside a whole state, with as many channels as there can be."""
    return scene((*STATE, *WORKS))


def plane():
    """A plane flow; one more channel for the sake of dependence only."""
    return scene(("u", "v", "omega_z"), channels=("w_hat",))


def normal_velocity():
    """One variable, one condition."""
    return scene(("v",), alpha_deg=(90.0,), speed=(100.0,))


def pruned():
    """The upper nodes of the full table and two of its variables, as `tablegen prune` leaves them.

    The look-up of the axes goes on beyond the nodes, and their numbers begin at 1.
    """
    whole = make_contents()
    channels = whole.channels[: whole.channels.index("omega_z") + 1]
    n, path = len(channels), "dependence/"
    kept = {p.removeprefix(path): x[1:, 1:] for p, x in whole.datasets.items() if path in p}
    kept["mean"] = kept["mean"][..., :n]
    kept["cholesky"] = kept["cholesky"][..., : n * (n + 1) // 2]
    places = [channels.index(name) for name in ("v", "omega_z")]
    quantiles = whole["marginals/quantiles"][1:, 1:][:, :, :, places]
    alpha, speed = ([whole[name] for name in names] for names in (AXES[:3], AXES[3:]))
    alpha[0], speed[0] = alpha[0][1:], speed[0][1:]
    knots = whole["marginals/variate_knots"]
    return table_of(("v", "omega_z"), channels, alpha, speed, knots, quantiles, **kept)


SMALL_TABLES = {
    "full": make_contents,
    "all-eight": all_eight,
    "works": works,
    "plane": plane,
    "pruned": pruned,
    "normal-velocity": normal_velocity,
}
