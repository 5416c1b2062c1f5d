"""Tables with a spin law whose numbers are random: of no particle, but within all bounds."""

from dataclasses import replace

import numpy as np

from sampler.formats.bounds import (
    GROUP_SIZE,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
)
from sampler.formats.channels import has_works
from sampler.formats.hdf5 import TableContents

#: What a table has whose spin law was not compared with anything.
_NOT_MEASURED = {
    "alpha_deg": np.zeros(0),
    "speed": np.zeros(0),
    "spin": np.zeros((0, 3)),
    "ks": np.zeros((0, N_OUTCOMES)),
    "sliced_wasserstein": np.zeros(0),
    "correlation_error": np.zeros(0),
    "auc": np.zeros(0),
    "joint_ks": np.zeros((0, N_OUTCOMES)),
    "joint_auc": np.zeros(0),
    **{f"cell_{name}": np.zeros(0) for name in ("ks", "energy")},
    **{f"chain_{name}": np.zeros(0) for name in ("ks", "energy", "spin")},
}

#: Coefficients of the moments of inertia of ellipsoids, prisms and spheres; others are made up.
MOMENTS = {0: (0.2, 0.2), 1: (1 / 3, 1 / 3), 4: (0.2, 0.2)}


def _trees(n_shapes: int, depth: int) -> dict[str, np.ndarray]:
    """For each shape a root that asks for spin, and a balanced tree behind it."""
    roots, axes, cuts, children, leaf = [], [], [], [], 0

    def grow(level: int) -> int:
        nonlocal leaf
        if level == depth:
            leaf += 1
            return -leaf
        here = len(axes)
        axes.append(level % 5)
        cuts.append((0.7, 0.3, 0.4, 0.0, 0.0)[level % 5])
        children.append([0, 0])
        children[here] = [grow(level + 1), grow(level + 1)]
        return here

    for _ in range(n_shapes):
        roots.append(len(axes))
        axes.append(5)
        cuts.append(1e-12)
        children.append([0, 0])
        leaf += 1
        children[roots[-1]] = [-leaf, grow(0)]
    return {
        "spin/roots": np.array(roots, np.int32),
        "spin/node_axis": np.array(axes, np.int8),
        "spin/node_cut": np.array(cuts),
        "spin/node_child": np.array(children, np.int32),
    }


def spin_datasets(
    seed: int = 1, *, codes=(0, 1, 3), depth: int = 2, outcomes: int = N_OUTCOMES
) -> dict[str, np.ndarray]:
    """Datasets of a spin law."""
    rng = np.random.default_rng(seed)
    trees = _trees(len(codes), depth)
    leaves = len(codes) * (2**depth + 1)

    def integers(spread: float, *shape: int) -> np.ndarray:
        return np.rint(rng.normal(0.0, spread, shape)).astype(np.int16)

    factor = integers(300.0, leaves, N_EXPERTS, outcomes * (outcomes + 1) // 2)
    diagonal = [row * (row + 3) // 2 for row in range(outcomes)]
    factor[..., diagonal] = np.abs(factor[..., diagonal]) + 400
    knots = np.cumsum(rng.exponential(1.0, (leaves, outcomes, 33)), axis=-1)
    quantiles = (knots / knots[..., -1:] - 0.5) * 1.5
    quantiles[:, 1] = 0.6 * (quantiles[:, 1] - quantiles[:, 1, :1])
    quantiles[:, 6:] += 0.75
    weights = rng.uniform(0.5, 1.5, len(codes))
    return {
        "spin/shape_codes": np.array(codes, np.int32),
        "spin/shape_weights": weights / weights.sum(),
        "spin/ratio_range": np.array([[[0.5, 1.0], [0.5, 1.0]]] * len(codes)),
        "spin/aspect": np.array([[0.8, 0.2, 0.0668072012688581, 0.841344746068543]] * 2),
        "spin/speed_coordinate": np.array([0.1, 0.61]),
        "spin/alpha_range_deg": np.array([0.5, 90.0]),
        "spin/speed_range": np.array([5.0, 600.0]),
        "spin/spin_range": np.array([0.0, 10.0]),
        "spin/shape_inertia": np.array([MOMENTS.get(code, (0.25, 0.15)) for code in codes]),
        **trees,
        "spin/centre": np.tile(
            np.array([0.7, 0.3, 0.4, 0.0, 0.0, 0.75, 0.75], np.float32), (leaves, 1)
        ),
        "spin/scale": np.full((leaves, N_INPUTS), 2.0, np.float32),
        "spin/group_gate": integers(400.0, leaves, N_FEATURES, N_GROUPS),
        "spin/gate": integers(400.0, leaves, N_GROUPS, N_FEATURES, GROUP_SIZE),
        "spin/mean": integers(400.0, leaves, N_EXPERTS, N_FEATURES, outcomes),
        "spin/factor": factor,
        "spin/quantiles": quantiles.astype(np.float32),
        **{f"spin_accuracy/{name}": values for name, values in _NOT_MEASURED.items()},
    }


def with_spin_law(contents: TableContents, seed: int = 1, **size: int) -> TableContents:
    """Table with a random spin law beside its own."""
    size |= {"outcomes": 8} if has_works(contents.variables) else {}
    datasets = dict(contents.datasets) | spin_datasets(seed, **size)
    law = {"omega": "mean", "least_inertia": 0.01, "valid_speed": (50.0, 300.0)}
    return replace(contents, datasets=datasets, **law)


def less_spheres(contents: TableContents) -> TableContents:
    """Table whose outcomes are less those of spheres: with constant laws, in place of its own."""
    laws = np.array([1e-6, 2.0, 0.6, 0.0, 1.0, 0.0, 0.3, 0.0])
    quantiles = contents["spin/quantiles"].copy()
    quantiles[:, 1] -= 0.3
    changed = {"spin/laws": laws, "spin/quantiles": quantiles}
    return replace(contents, datasets=dict(contents.datasets) | changed)


def energies(contents: TableContents, states, spin, grains):
    """Least energy after and most before, for the own grains, in m V^2 / 2."""
    codes, beta, gamma = grains.T
    rows = np.searchsorted(contents["spin/shape_codes"], codes)
    g1, g3 = contents["spin/shape_inertia"][rows].T
    largest, smallest = g1 * (1.0 + beta**2), g3 * beta**2 * (1.0 + gamma**2)
    after = (states[:, :3] ** 2).sum(axis=1) + smallest * (states[:, 3:] ** 2).sum(axis=1)
    return after, 1.0 + largest * (spin**2).sum(axis=1)
