"""Pruned tables: the same draws for the same keys."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from tiny_tables import ROUGH

import sampler
from sampler.formats.channels import STATE, WORKS
from sampler.formats.hdf5 import read_table
from tablegen.config.config import parse_config
from tablegen.tables.axes import make_axes
from tablegen.tables.generate import generate
from tablegen.tables.intervals import Grid
from tablegen.tables.prune import prune, pruned

#: Four angles and three speeds, so that a scene can leave some out.
NODES = {"alpha_nodes_deg": [10.0, 30.0, 50.0, 80.0], "speed_nodes": [60.0, 150.0, 300.0]}
WIDE = ROUGH.with_changes({"domain": {"alpha_deg": [10.0, 80.0], "speed": [60.0, 300.0]}})
WIDE = WIDE.with_changes({"table": NODES, "population": {"shapes": {"prism": 1.0}}})


@pytest.fixture(scope="module")
def wide(tmp_path_factory):
    path = tmp_path_factory.mktemp("wide") / "wide.h5"
    everything = WIDE.with_changes(
        {"domain": {"variables": [*STATE, "rotational_energy", "collisions"]}}
    )
    generate(everything, path, conditions=0)
    return path


def _scene(**domain):
    return WIDE.with_changes({"domain": domain})


def _draws(path, alpha_deg=(10.0, 80.0), speed=(60.0, 300.0)):
    """States by component, over a range of conditions, keys and hits."""
    table = sampler.load(path, outside="raise")
    rng = np.random.default_rng(3)
    n = 4000
    alpha1 = np.deg2rad(np.append(rng.uniform(*alpha_deg, n - 2), alpha_deg))
    speeds = np.append(rng.uniform(*speed, n - 2), speed)
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    states = table.sample(alpha1, speeds, seed=9, index=index, hit=np.arange(n) % 7)
    return dict(zip(table.columns, states.T, strict=True))


@pytest.mark.parametrize(
    "variables",
    [STATE, ("u", "v", "omega_z"), ("v", "rotational_energy"), ("collisions",)],
    ids=" ".join,
)
def test_variables_that_stay_have_the_same_draws(wide, tmp_path, variables):
    cut = tmp_path / "cut.h5"
    prune(wide, _scene(variables=list(variables)), cut)
    full, part = _draws(wide), _draws(cut)
    assert tuple(part) == variables
    for name in variables:
        np.testing.assert_array_equal(part[name], full[name])
    assert cut.stat().st_size < wide.stat().st_size


@pytest.mark.parametrize(
    ("alpha_deg", "speed", "kept"),
    [
        ((30.0, 50.0), (150.0, 300.0), ([30.0, 50.0], [150.0, 300.0])),
        ((31.0, 49.0), (70.0, 80.0), ([30.0, 50.0], [60.0, 150.0])),
        ((80.0, 80.0), (60.0, 60.0), ([50.0, 80.0], [60.0, 150.0])),
    ],
)
def test_conditions_that_stay_have_the_same_draws(wide, tmp_path, alpha_deg, speed, kept):
    cut = tmp_path / "cut.h5"
    prune(wide, _scene(alpha_deg=list(alpha_deg), speed=list(speed)), cut)
    table = sampler.load(cut)
    nodes = (list(table.alpha_nodes_deg), list(table.speed_nodes))
    # a node at the end of the scene may keep its neighbour: its coordinate is rounded
    assert all(set(want) <= set(got) for want, got in zip(kept, nodes, strict=True))
    assert all(len(got) <= len(want) + 1 for want, got in zip(kept, nodes, strict=True))
    full, part = _draws(wide, alpha_deg, speed), _draws(cut, alpha_deg, speed)
    for name in part:
        np.testing.assert_array_equal(part[name], full[name])


def test_accuracy_stays_where_conditions_and_variables_do(wide, tmp_path):
    whole = read_table(wide)
    count = len(whole.variables)
    measured = {
        "accuracy/alpha_deg": np.array([12.0, 35.0, 45.0, 70.0]),
        "accuracy/speed": np.array([100.0, 200.0, 100.0, 200.0]),
        "accuracy/ks": np.arange(4.0 * count).reshape(4, count) / 100.0,
        **{
            f"accuracy/{name}": np.arange(4.0) / 4.0
            for name in ("sliced_wasserstein", "correlation_error")
        },
        "accuracy/auc": np.full(4, 0.6),
    }
    whole = replace(whole, datasets={**whole.datasets, **measured})
    variables = list(whole.variables)
    cut = pruned(whole, _scene(alpha_deg=[31.0, 49.0], variables=variables))
    np.testing.assert_array_equal(cut["accuracy/ks"], measured["accuracy/ks"][1:3])
    np.testing.assert_array_equal(cut["accuracy/correlation_error"], [0.25, 0.5])
    fewer = pruned(whole, _scene(alpha_deg=[31.0, 49.0], variables=variables[:2]))
    assert fewer["accuracy/ks"].shape == (0, 2)
    assert fewer["accuracy/auc"].size == 0


@pytest.fixture(scope="module")
def spinning(tmp_path_factory):
    """Table with works and a spin law, and its configuration."""
    path = tmp_path_factory.mktemp("spinning") / "whole.h5"
    sizes = {"spin_leaves": 1, "spin_groups": 2, "spin_experts": 2, "spin_rebounds": 1000}
    changes = {"spin": True, "table": sizes, "domain": {"variables": [*STATE, *WORKS]}}
    config = WIDE.with_changes(changes)
    generate(config, path, conditions=0)
    return path, config


@pytest.mark.parametrize(
    "kept", [STATE, ("u", "v", "omega_z"), ("u", "v", "w", *WORKS)], ids=" ".join
)
def test_what_stays_of_both_laws_has_the_same_draws(spinning, tmp_path, kept):
    whole, config = spinning
    prune(whole, config.with_changes({"domain": {"variables": list(kept)}}), tmp_path / "cut.h5")
    full, part = sampler.load(whole), sampler.load(tmp_path / "cut.h5")
    assert part.columns == kept
    outcomes = 8 if "work_shear" in kept else 7
    assert read_table(tmp_path / "cut.h5")["spin/mean"].shape[-1] == outcomes
    columns = [full.columns.index(name) for name in kept]
    out = [k for k, name in enumerate(STATE) if name not in kept]
    keys = {"seed": 3, "index": np.arange(500), "hit": 0}
    after = np.empty((2, 500))
    for spin in (None, [0.3, -0.5, 0.8]):
        states = full.sample(0.8, 100.0, spin=spin, **keys, inertia_after=after[0])
        cut_states = part.sample(0.8, 100.0, spin=spin, **keys, inertia_after=after[1])
        np.testing.assert_array_equal(cut_states, states[:, columns])
        np.testing.assert_array_equal(*after)
    # the impact has the axes of the laboratory, where variables that are left out are 0
    impact = [60.0, -80.0, 0.0], [0.0, 1.0, 0.0], 1e-3
    for arrival in ({"grain": "fresh"}, {}, {"omega": [3e4, -5e4, 8e4]}):
        whole_rebound = full.rebound(*impact, **arrival, **keys)
        cut_rebound = part.rebound(*impact, **arrival, **keys)
        states = np.hstack([whole_rebound.velocity, whole_rebound.omega])
        states[:, out] = 0.0
        np.testing.assert_array_equal(np.hstack([cut_rebound.velocity, cut_rebound.omega]), states)
        np.testing.assert_array_equal(cut_rebound.inertia, whole_rebound.inertia)


@pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
def test_the_spin_law_keeps_its_angles_and_cuts_its_speeds(spinning, tmp_path):
    whole, config = spinning
    cut = config.with_changes({"domain": {"alpha_deg": [31.0, 49.0], "speed": [160.0, 170.0]}})
    prune(whole, cut, tmp_path / "cut.h5")
    full, part = sampler.load(whole), sampler.load(tmp_path / "cut.h5")
    assert part.covered.alpha_deg == pytest.approx((30.0, 50.0))
    assert part.covered.speed == (150.0, 300.0)
    assert part.covered.spin == full.covered.spin
    inside, beyond = np.radians([30.0, 50.0, 40.0]), np.radians([12.0, 70.0, 40.0])
    keys = {"spin": [0.0, 0.0, 1.0], "seed": 3, "index": np.arange(3), "hit": 0}
    for angles in (inside, beyond):
        np.testing.assert_array_equal(
            part.sample(angles, 200.0, **keys), full.sample(angles, 200.0, **keys)
        )
    slow = part.sample(0.7, 80.0, **keys | {"spin": [0.0, 0.0, 0.0]})
    np.testing.assert_array_equal(slow, full.sample(0.7, 150.0, **keys | {"spin": [0.0] * 3}))
    assert (part.counts["angle"], part.counts["speed"]) == (0, 3)
    part.sample(beyond, 200.0, seed=3, index=np.arange(3), hit=0, grain="fresh")
    assert part.counts["angle"] == 2


def test_grains_that_got_slow_keep_their_draws(spinning, tmp_path):
    """If a scene keeps the slowest node, the spin law still reaches far below it."""
    whole, config = spinning
    prune(whole, config.with_changes({"domain": {"variables": list(STATE)}}), tmp_path / "cut.h5")
    full, part = sampler.load(whole), sampler.load(tmp_path / "cut.h5")
    keys = {"spin": [0.3, -0.5, 0.8], "seed": 3, "index": np.arange(500), "hit": 1}
    np.testing.assert_array_equal(
        part.sample(0.8, 1.0, **keys), full.sample(0.8, 1.0, **keys)[:, : len(STATE)]
    )
    assert part.counts["speed"] == 0


def test_cut_table_says_what_it_is(wide, tmp_path):
    cut = tmp_path / "cut.h5"
    prune(wide, _scene(variables=["u", "v"], alpha_deg=[31.0, 49.0]), cut)
    contents = read_table(cut)
    config = parse_config(contents.config, "cut")
    assert config.domain.columns == ("u", "v") == contents.variables
    assert config.domain.alpha_deg == (30.0, 50.0)
    assert contents["accuracy/ks"].shape == (0, 2)
    assert contents.channels == ("v", "u_hat")
    # and can be cut again, and generated from its own configuration
    assert pruned(contents, config).content_sha256 == contents.content_sha256
    assert len(make_axes(config, Grid((30.0, 50.0), (60.0, 300.0))).alpha_deg) == 2


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("domain.alpha_deg", {"domain": {"alpha_deg": [5.0, 80.0]}}),
        ("domain.speed", {"domain": {"speed": [50.0, 300.0]}}),
        ("accuracy.ks", {"accuracy": {"ks": 0.5}}),
        ("population", {"population": {"truncation": 0.3}}),
        ("model", {"model": {"tolerance": 1e-9}}),
        ("pair", {"pair": {"name": "other"}}),
    ],
)
def test_scenes_beyond_the_table_are_refused(wide, tmp_path, field, changes):
    refused(f"scene: {field}", prune, wide, WIDE.with_changes(changes), tmp_path / "cut.h5")
    assert not list(tmp_path.iterdir())
    velocities = pruned(read_table(wide), _scene(variables=["u", "v"]))
    refused("scene: domain.variables", pruned, velocities, _scene(variables=["u", "w"]))
