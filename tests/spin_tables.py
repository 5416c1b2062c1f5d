"""Tables with a spin law of random numbers: within all bounds, but of no real particle."""

from dataclasses import replace

import numpy as np

from sampler.formats.bounds import (
    GROUP_SIZE,
    N_CONDITIONS,
    N_EXPERTS,
    N_FEATURES,
    N_GROUPS,
    N_INPUTS,
    N_OUTCOMES,
    N_OUTCOMES_WITH_WORKS,
)
from sampler.formats.channels import has_works
from sampler.formats.layout import ACCURACY, SPIN_DATASETS
from sampler.formats.shape_codes import FIRST_MESH
from sampler.formats.shape_geometry import geometry_of_shape

#: What a table has whose spin law was not compared with anything.
_NOT_MEASURED = {"ks": (0, 6), "spin": (0, 3)}
_NOT_MEASURED |= dict.fromkeys(("alpha_deg", "speed", "sliced_wasserstein"), 0)
_NOT_MEASURED |= dict.fromkeys(("correlation_error", "auc"), 0)
_NOT_MEASURED |= {d.path.removeprefix(ACCURACY): 0 for d in SPIN_DATASETS if "n_chained" in d.dims}

#: Coefficients of the moments of inertia of ellipsoids, prisms and spheres; others are made up.
MOMENTS = {0: (0.2, 0.2), 1: (1 / 3, 1 / 3), 4: (0.2, 0.2)}


def _trees(n_shapes, depth):
    """Make a tree for each shape: a root that asks for spin, and a balanced tree below it."""
    roots, axes, cuts, children, leaf = [], [], [], [], 0

    def node(axis, cut):
        axes.append(axis)
        cuts.append(cut)
        children.append([0, 0])
        return len(axes) - 1

    def grow(level):
        nonlocal leaf
        if level == depth:
            leaf += 1
            return -leaf
        axis = level % N_CONDITIONS
        here = node(axis, (0.7, 0.3, 0.5, 0.0, 0.0, 0.5, 0.0)[axis])
        children[here] = [grow(level + 1), grow(level + 1)]
        return here

    for _ in range(n_shapes):
        roots.append(node(N_CONDITIONS, 1e-12))
        leaf += 1
        children[roots[-1]] = [-leaf, grow(0)]
    return {
        "roots": np.array(roots, np.int32),
        "node_axis": np.array(axes, np.int8),
        "node_cut": np.array(cuts),
        "node_child": np.array(children, np.int32),
    }


def _law(seed, codes=(0, 1, 3), depth=2, outcomes=N_OUTCOMES):
    """Datasets of a spin law."""
    rng = np.random.default_rng(seed)
    leaves = len(codes) * (2**depth + 1)

    def integers(spread, *shape):
        return np.rint(rng.normal(0.0, spread, shape)).astype(np.int16)

    factor = integers(300.0, leaves, N_EXPERTS, outcomes * (outcomes + 1) // 2)
    diagonal = [row * (row + 3) // 2 for row in range(outcomes)]
    factor[..., diagonal] = np.abs(factor[..., diagonal]) + 400
    knots = np.cumsum(rng.exponential(1.0, (leaves, outcomes, 33)), axis=-1)
    quantiles = (knots / knots[..., -1:] - 0.5) * 1.5
    quantiles[:, 1] = 0.6 * (quantiles[:, 1] - quantiles[:, 1, :1])
    quantiles[:, 6] *= 20.0  # odds of kappa from e^-15 to e^15 times those before
    quantiles[:, 7:] += 0.75
    weights = rng.uniform(0.5, 1.5, len(codes))
    return _trees(len(codes), depth) | {
        "shape_codes": np.array(codes, np.int32),
        "shape_weights": weights / weights.sum(),
        "ratio_range": np.array([[[0.5, 1.0], [0.5, 1.0]]] * len(codes)),
        "aspect": np.array([[0.8, 0.2, 0.0668072012688581, 0.841344746068543]] * 2),
        "speed_coordinate": np.array([0.1, 0.61]),
        "spin_range": np.array([0.0, 10.0]),
        "shape_inertia": np.array([MOMENTS.get(code, (0.25, 0.15)) for code in codes]),
        # a mesh has that of an ellipsoid here
        "shape_geometry": np.array([geometry_of_shape(code % FIRST_MESH) for code in codes]),
        "kappa_quantiles": np.sort(rng.uniform(size=(len(codes), 33)), axis=1),
        "centre": np.tile(
            np.array([0.7, 0.3, 0.4, 0.0, 0.0, 0.5, 0.0, 0.75, 0.75], "f4"), (leaves, 1)
        ),
        "scale": np.full((leaves, N_INPUTS), 2.0, np.float32),
        "group_gate": integers(400.0, leaves, N_FEATURES, N_GROUPS),
        "gate": integers(400.0, leaves, N_GROUPS, N_FEATURES, GROUP_SIZE),
        "mean": integers(400.0, leaves, N_EXPERTS, N_FEATURES, outcomes),
        "factor": factor,
        "quantiles": quantiles.astype(np.float32),
    }


#: Tabulated laws of contact: of restitution at three angles and two speeds, of resistance at two.
LAWS = np.array(
    [
        *(1e-3, 4.0, 0.0, 0.0, 2.0, 0.0, 0.0, 13.0),
        *(3.0, 2.0, 0.1, 0.7, 1.5, 60.0, 200.0, 0.95, 0.8, 0.6, 0.5, 0.5, 0.3),
        *(2.0, 1.0, 0.2, 1.4, 1.0, 0.3, 0.1),
    ]
)


def with_spin_law(contents, seed=1, laws=None, **size):
    """Return a table with a random spin law added; `size` is that of `_law`.

    With laws of contact, ellipsoids without spin count from a sphere.
    """
    size |= {"outcomes": N_OUTCOMES_WITH_WORKS} if has_works(contents.variables) else {}
    datasets = contents.datasets | {f"spin/{name}": x for name, x in _law(seed, **size).items()}
    # one range of angles for both laws, and room for the energy of a spin
    low, high = contents["axes/speed"][[0, -1]]
    datasets |= {
        "spin/alpha_range_deg": contents["axes/alpha_deg"][[0, -1]],
        "spin/speed_range": np.array([low, 2.0 * high]),
    }
    datasets |= {} if laws is None else {"spin/laws": laws}
    datasets |= {f"spin_accuracy/{name}": np.zeros(n) for name, n in _NOT_MEASURED.items()}
    law = {"least_inertia": 0.01, "valid_speed": (50.0, 300.0)}
    return replace(contents, datasets=datasets, **law)


def moments(contents, grains):
    """Smallest and largest moment of inertia of grains (n, 3) over m a^2."""
    codes, beta, gamma = np.transpose(grains)
    rows = np.searchsorted(contents["spin/shape_codes"], codes)
    g1, g3 = contents["spin/shape_inertia"][rows].T
    return g3 * beta**2 * (1.0 + gamma**2), g1 * (1.0 + beta**2)


def energy(velocity, spin, inertia):
    """Energy in m V^2 / 2 of velocities over V, spins times a/V and inertias about them."""
    return (velocity**2).sum(axis=-1) + inertia * (spin**2).sum(axis=-1)
