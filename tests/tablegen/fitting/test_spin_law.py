"""Whole spin laws, small: any population has one, it follows the direct model, and runs resume."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from mesh_fixtures import box
from spin_laws import chain_sample
from tiny_tables import ROUGH

from sampler.formats.channels import STATE, WORKS
from sampler.formats.hdf5 import read_table
from sampler.formats.layout import GROUP, SPIN_DATASETS
from tablegen.accuracy.metrics import ks_distances
from tablegen.checkpoints import TaskRunner
from tablegen.fitting.leaf import fit_leaf
from tablegen.fitting.spin_law import speed_coordinate, spin_law
from tablegen.meshes.mesh_file import MeshFile
from tablegen.simulation.impact_chains import energy_factor
from tablegen.tables.generate import generate
from tablegen.tables.plan import make_plan

pytestmark = pytest.mark.usefixtures("quick_measurement")

SMALL = {"spin_leaves": 1, "spin_groups": 2, "spin_experts": 2, "spin_rebounds": 1000}
PRISMS = {"ellipsoid": 0.0, "prism": 1.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
SPINNING = ROUGH.with_changes({"spin": True, "population": {"shapes": PRISMS}, "table": SMALL})


def test_does_not_depend_on_the_workers_nor_on_blocks(monkeypatch):
    def small_law(config, threads=1):
        with ThreadPoolExecutor(threads) as pool:
            return spin_law(config, TaskRunner(executor=pool), make_plan(config).spin)

    config = SPINNING.with_changes({"table": {"spin_leaves": 2}})
    one = small_law(config)
    monkeypatch.setattr("tablegen.fitting.spin_law._BLOCK", 300)  # of 1000 rebounds
    monkeypatch.setattr("tablegen.fitting.leaf._BLOCK", 300)
    two = small_law(config, threads=3)
    paths = {dataset.path for dataset in SPIN_DATASETS if dataset.path.startswith(GROUP)}
    assert one.keys() == paths == two.keys()
    for path, values in one.items():
        np.testing.assert_array_equal(values, two[path])
    again = small_law(config.with_changes({"table": {"seed": 6}}))
    assert (one["spin/mean"] != again["spin/mean"]).any()


def configuration(kind):
    """Configuration in which nothing is random, or ratios or conditions do not vary."""
    if kind == "mesh":
        corners = tuple(map(tuple, box(0.8, 0.4).tolist()))
        mesh = MeshFile("box", corners, len(corners), 1.0, False)
        population = SPINNING.population.with_mesh(mesh)
        fields = population.model_dump(mode="json", by_alias=True)
        return SPINNING.with_changes({"population": fields})
    changes = {
        "sphere": {"population": {"shapes": PRISMS | {"prism": 0.5, "sphere": 0.5}}},
        "fixed": {"population": {"aspect": {"distribution": "fixed", "values": [0.8, 0.7]}}},
        "one condition": {
            "domain": {"alpha_deg": [40.0, 40.0], "speed": [100.0, 100.0]},
            "table": {"alpha_nodes_deg": [40.0], "speed_nodes": [100.0], "spin_leaves": 2},
        },
    }
    return SPINNING.with_changes(changes[kind])


def inertias(grains, contents):
    """Smallest and largest moments of grains over m a^2, by what a table says of them."""
    rows = np.searchsorted(contents["spin/shape_codes"], grains[:, 0])
    first, third = contents["spin/shape_inertia"][rows].T
    beta, gamma = np.square(grains[:, 1:]).T
    return third * beta * (1.0 + gamma), first * (1.0 + beta)


@pytest.mark.parametrize("kind", ["sphere", "mesh", "fixed", "one condition"])
def test_any_population_and_domain_has_a_law(kind, tmp_path):
    path = tmp_path / "t.h5"
    table, contents = generate(configuration(kind), path, conditions=0).table, read_table(path)
    spin = np.random.default_rng(7).normal(0.0, 0.5, (500, 3))
    keys, after = {"seed": 1, "index": np.arange(500), "hit": 0}, np.empty(500)
    states = table.sample(np.radians(40.0), 70.0, spin=spin, inertia_after=after, **keys)
    assert np.isfinite(states).all()
    assert (states[:, 1] > 0.0).all()
    # no rebound of any grain gains energy, whatever inertia it came with
    gained = np.sum(states[:, :3] ** 2, axis=1) + after * np.sum(states[:, 3:] ** 2, axis=1)
    gained -= 1.0 + 2.0 / 3.0 * np.sum(spin**2, axis=1)
    assert gained.max() < 0.0
    moments = inertias(table.grains(1, np.arange(500)), contents)
    assert (after >= moments[0] * (1.0 - 1e-6)).all()
    assert (after <= moments[1] * (1.0 + 1e-6)).all()
    quantiles = contents["spin/kappa_quantiles"]
    assert (np.diff(quantiles, axis=1) >= 0.0).all()
    assert 0.0 <= quantiles.min() <= quantiles.max() <= 1.0


def test_a_small_law_follows_chains_and_a_wrong_one_does_not(tmp_path):
    """At particles that spin forwards; equal laws exceed the bound in one of 9 with p = 0.009."""
    domain = {"alpha_deg": [2.0, 90.0], "speed": [20.0, 300.0], "extrapolate": True}
    changes = {
        "spin": True,
        "domain": domain | {"variables": [*STATE, *WORKS]},
        "table": {"alpha_nodes_deg": [2.0, 90.0], "speed_nodes": [20.0, 300.0]}
        | {"spin_leaves": 6, "spin_groups": 8, "spin_experts": 4, "spin_rebounds": 20_000},
    }
    config = SPINNING.with_changes(changes)
    table = generate(config, tmp_path / "t.h5", conditions=0).table
    impacts, departures, bound = chain_sample(config, -0.3)
    assert bound < 0.065
    direct = np.column_stack([departures.states, departures.works, departures.inertia])

    def drawn(turned=(1.0, 1.0, 1.0), inertia=impacts.inertia):
        after = np.empty(len(impacts.index))
        states = table.sample(
            impacts.alpha1,
            impacts.speed,
            spin=impacts.spin * turned,
            inertia=inertia,
            seed=3,
            index=impacts.index,
            hit=impacts.hit,
            grain=impacts.grain,
            inertia_after=after,
        )
        return np.column_stack([states, after])

    right = drawn()
    assert max(ks_distances(right, direct)) < bound
    assert max(ks_distances(drawn((1.0, 1.0, -1.0)), direct)) > 2.0 * bound
    # energy is lost to the wall in each rebound, and nowhere else
    before = energy_factor(impacts.spin, impacts.inertia) ** 2
    after = np.sum(right[:, :3] ** 2, axis=1) + right[:, 8] * np.sum(right[:, 3:6] ** 2, axis=1)
    np.testing.assert_allclose(after + right[:, 6:8].sum(axis=1), before, rtol=1e-5)
    # the normal work is not the shear work, and an inertia that is not the own one is seen
    assert min(ks_distances(right[:, [7, 6]], direct[:, 6:8])) > 2.0 * bound
    moments = inertias(impacts.grain, read_table(tmp_path / "t.h5"))
    assert ks_distances(drawn(inertia=moments[0])[:, 8:], direct[:, 8:]).max() > 1.5 * bound


def test_an_interrupted_law_resumes(tmp_path, monkeypatch):
    whole, resumed = tmp_path / "whole.h5", tmp_path / "resumed.h5"
    calls = []

    def failing(*arguments, **settings):
        calls.append(arguments)
        if len(calls) == 2:
            raise RuntimeError("interrupted")
        return fit_leaf(*arguments, **settings)

    with ThreadPoolExecutor(1) as pool:
        generate(SPINNING, whole, conditions=0, executor=pool)
        monkeypatch.setattr("tablegen.fitting.spin_law.fit_leaf", failing)
        with pytest.raises(RuntimeError, match="interrupted"):
            generate(SPINNING, resumed, conditions=0, executor=pool)
        assert not resumed.exists()
        generate(SPINNING, resumed, conditions=0, executor=pool, resume=True)
    # the first of two leaves came from its checkpoint
    assert len(calls) == 3
    assert resumed.read_bytes() == whole.read_bytes()


def test_coordinate_of_the_speed_is_that_of_the_restitution_law_if_it_fits():
    assert speed_coordinate(SPINNING)[:2] == (0.1, 0.61)
    constant = {"law": "constant", "value": 0.5, "source": "a test"}
    config = SPINNING.with_changes(
        {"pair": {"restitution": constant}, "domain": {"extrapolate": True}}
    )
    values = speed_coordinate(config).transform(np.array([1.0, 120.0, 600.0]))
    assert np.ptp(values) < 1e-4  # the law does not depend on the speed, and no leaf is cut in it
