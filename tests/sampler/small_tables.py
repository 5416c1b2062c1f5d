"""Tables of a few kilobytes with made-up numbers, one for each kind of scene."""

import numpy as np
from synthetic_table import make_contents, make_datasets

from sampler.formats.channels import CHANNELS, STATE, WORKS, channels_for

N_KNOTS, N_GRID, N_COMPONENTS, N_CLASSES = 9, 17, 4, 2


def full():
    """Six components, three nodes an axis."""
    return make_contents()


def scene(components, alpha_deg=(20.0, 70.0), speed=(50.0, 120.0), seed=3, channels=()):
    """A table for some components; channels beyond theirs only carry dependence."""
    rng = np.random.default_rng(seed)
    marginals = channels_for(components)
    held = [name for name in CHANNELS if name in {*marginals, *channels}]
    nodes = (len(alpha_deg), len(speed))
    low = {"v": 0.05, "energy_hat": 0.01, "collisions": 1.0, "normal_hat": 0.02}
    high = {"omega_x": 2.0, "omega_y": 2.0, "omega_z": 2.0, "collisions": 6.5}
    ends = [(low.get(name, -0.9), high.get(name, 0.9)) for name in marginals]
    quantiles = np.empty((*nodes, N_CLASSES, len(marginals), N_KNOTS))
    for k, (a, b) in enumerate(ends):
        inside = np.sort(rng.uniform(size=(*nodes, N_CLASSES, N_KNOTS)), axis=-1)
        quantiles[..., k, :] = a + (b - a) * inside
    shape = (*nodes, N_COMPONENTS)
    n = len(held)
    factors = rng.integers(-2500, 2500, (*shape, n * (n + 1) // 2))
    diagonal = [row * (row + 3) // 2 for row in range(n)]
    factors[..., diagonal] = rng.integers(1500, 4000, (*shape, n))
    coordinate = {
        name: np.linspace(0.0, np.sqrt(length - 1.0), N_GRID) ** 2
        for name, length in zip(("alpha", "speed"), nodes, strict=True)
    }
    datasets = make_datasets() | {
        "axes/alpha_deg": np.array(alpha_deg),
        "axes/alpha_span_deg": np.array(alpha_deg)[[0, -1]],
        "axes/speed": np.array(speed),
        "axes/speed_span": np.array(speed)[[0, -1]],
        "axes/alpha_coordinate": coordinate["alpha"],
        "axes/speed_coordinate": coordinate["speed"],
        "marginals/variate_knots": np.linspace(-3.0, 3.0, N_KNOTS),
        "marginals/quantiles": quantiles,
        "dependence/first_of_class": np.broadcast_to([0, 1], (*nodes, N_CLASSES)),
        "dependence/alias_probability": rng.integers(0, 65536, shape),
        "dependence/alias_index": rng.integers(0, N_COMPONENTS, shape),
        "dependence/reflection": rng.integers(0, 4097, shape),
        "dependence/mean": rng.integers(-4000, 4000, (*shape, n)),
        "dependence/cholesky": factors,
        "accuracy/ks": np.full((2, len(components)), 0.01),
    }
    return make_contents(datasets, variables=tuple(components), channels=tuple(held))


def all_eight():
    """Every component but the works, as many as a table can have; one node an axis of speed."""
    names = ("u", "v", "w", "omega_x", "omega_y", "omega_z", "rotational_energy", "collisions")
    return scene(names, speed=(120.0,))


def works():
    """The work of the impulses beside a whole state, with as many channels as there can be."""
    return scene((*STATE, *WORKS))


def plane():
    """A plane flow; one more channel for the sake of dependence only."""
    return scene(("u", "v", "omega_z"), channels=("w_hat",))


def normal_velocity():
    """One component, one condition."""
    return scene(("v",), alpha_deg=(90.0,), speed=(100.0,))


def pruned():
    """The upper nodes of the full table and two of its components, as `tablegen prune` leaves them.

    The look-up of the axes goes on beyond the nodes, and their numbers begin at 1.
    """
    whole = full()
    channels = whole.channels[: whole.channels.index("omega_z") + 1]
    n = len(channels)
    datasets = dict(whole.datasets)
    for path, values in whole.datasets.items():
        if path.startswith(("marginals/quantiles", "dependence/")):
            datasets[path] = values[1:, 1:]
    quantiles = datasets["marginals/quantiles"]
    datasets |= {
        "axes/alpha_deg": whole["axes/alpha_deg"][1:],
        "axes/speed": whole["axes/speed"][1:],
        "marginals/quantiles": quantiles[:, :, :, [channels.index(c) for c in ("v", "omega_z")]],
        "dependence/mean": datasets["dependence/mean"][..., :n],
        "dependence/cholesky": datasets["dependence/cholesky"][..., : n * (n + 1) // 2],
        "accuracy/ks": whole["accuracy/ks"][:, :2],
    }
    return make_contents(datasets, variables=("v", "omega_z"), channels=channels)


SMALL_TABLES = {
    "full": full,
    "all-eight": all_eight,
    "works": works,
    "plane": plane,
    "pruned": pruned,
    "normal-velocity": normal_velocity,
}
