"""The shipped table, made wrong in nine ways with a right checksum: validation notices each.

The wrong tables have wrong angles, exchanged variables, or classes of rebounds off by three per
cent; the seed is random. A single wrong node is found where a condition lies beside it only. Forged
declarations and contradicted configurations are in `test_validate`.
"""

import numpy as np
import pytest
from corrupt_tables import NODE_DATASETS, garbage, unreflected, with_datasets

from sampler.files import find_table
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.validate import validate
from tablegen.config.config import load_config
from tablegen.tables.axes import Grid, make_axes

CONFIG = load_config("corundum-steel")


def moved_angles(contents, shift, above=0.0):
    """Move the angles of the inner nodes above an angle."""
    alpha = contents["axes/alpha_deg"].copy()
    inner = np.arange(len(alpha))[1:-1]
    alpha[inner[alpha[1:-1] > above]] += shift
    axes = make_axes(CONFIG, Grid(tuple(alpha), tuple(contents["axes/speed"])))
    changes = {"axes/alpha_deg": alpha, "axes/alpha_coordinate": axes.alpha_coordinate}
    return with_datasets(contents, changes)


def exchanged(contents, one, other):
    """Exchange the quantiles of two channels."""
    quantiles = contents["marginals/quantiles"].copy()
    i, j = (contents.channels.index(name) for name in (one, other))
    quantiles[..., [i, j], :] = quantiles[..., [j, i], :]
    return with_datasets(contents, {"marginals/quantiles": quantiles})


def scaled(contents, channel, of_class, factor):
    """Multiply the quantiles of one channel, for one class of rebounds."""
    quantiles = contents["marginals/quantiles"].copy()
    quantiles[:, :, of_class, contents.channels.index(channel)] *= np.float32(factor)
    return with_datasets(contents, {"marginals/quantiles": quantiles})


def copied_speed(contents, source, target):
    """Copy the laws of all nodes of one speed to another speed."""
    arrays = {name: contents[name].copy() for name in NODE_DATASETS}
    for values in arrays.values():
        values[:, target] = values[:, source]
    return with_datasets(contents, arrays)


def mostly_garbage(contents):
    """Replace four of five nodes by garbage."""
    nodes = np.random.default_rng(7).random(contents["marginals/quantiles"].shape[:2]) < 0.8
    return garbage(contents, nodes)


WRONG = {
    "inner angles a degree up": lambda c: moved_angles(c, 1.0, above=2.0),
    "angles above 15 a degree down": lambda c: moved_angles(c, -1.0, above=16.0),
    "omega_x and omega_y exchanged": lambda c: exchanged(c, "omega_x", "omega_y"),
    "a speed copied": lambda c: copied_speed(c, 2, 3),
    "no reflection": unreflected,
    "omega_z of repeated collisions": lambda c: scaled(c, "omega_z", 1, 1.03),
    "v of single collisions": lambda c: scaled(c, "v", 0, 0.97),
    "u_hat of repeated collisions": lambda c: scaled(c, "u_hat", 1, 0.97),
    "garbage": mostly_garbage,
}


@pytest.mark.study
@pytest.mark.parametrize("change", WRONG)
def test_is_found_by_the_default_validation(tmp_path, change):
    path = tmp_path / "wrong.h5"
    write_table(path, WRONG[change](read_table(find_table("corundum-steel"))))
    result = validate(path)
    assert result.missed, f"seed {result.seed}"
