"""Whole spin laws, small: any population has one, it follows the direct model, and runs resume."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from mesh_fixtures import box
from spin_laws import chain_sample
from tiny_tables import ROUGH

from sampler.formats.channels import STATE, WORKS
from sampler.formats.layout import GROUP, SPIN_DATASETS
from tablegen.accuracy.metrics import ks_distances
from tablegen.checkpoints import TaskRunner
from tablegen.config.mesh import MeshFile
from tablegen.fitting.leaf import fit_leaf
from tablegen.fitting.spin_law import speed_coordinate, spin_law
from tablegen.tables.generate import generate
from tablegen.tables.plan import make_plan

pytestmark = pytest.mark.usefixtures("quick_measurement")

SMALL = {"spin_leaves": 1, "spin_groups": 2, "spin_experts": 2, "spin_rebounds": 1000}
PRISMS = {"ellipsoid": 0.0, "prism": 1.0, "truncated-prism": 0.0, "tetrahedron": 0.0}
SPINNING = ROUGH.with_changes({"spin": True, "population": {"shapes": PRISMS}, "table": SMALL})


def test_does_not_depend_on_the_workers():
    def made(config, threads=1):
        with ThreadPoolExecutor(threads) as pool:
            return spin_law(config, TaskRunner(executor=pool), make_plan(config).spin)

    config = SPINNING.with_changes({"table": {"spin_leaves": 2}})
    one, two = made(config), made(config, threads=3)
    paths = {dataset.path for dataset in SPIN_DATASETS if dataset.path.startswith(GROUP)}
    assert one.keys() == paths == two.keys()
    for path, values in one.items():
        np.testing.assert_array_equal(values, two[path])
    again = made(config.with_changes({"table": {"seed": 6}}))
    assert (one["spin/mean"] != again["spin/mean"]).any()


def configuration(kind):
    """Configuration in which nothing is random, or ratios or conditions do not vary."""
    if kind == "mesh":
        corners = tuple(map(tuple, box(0.8, 0.4).tolist()))
        population = SPINNING.population.of_mesh(MeshFile("box", corners, 1.0))
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


@pytest.mark.parametrize("kind", ["sphere", "mesh", "fixed", "one condition"])
def test_any_population_and_domain_has_a_law(kind, tmp_path):
    table = generate(configuration(kind), tmp_path / "t.h5", conditions=0).table
    spin = np.random.default_rng(7).normal(0.0, 0.5, (500, 3))
    states = table.sample(np.radians(40.0), 100.0, spin=spin, seed=1, index=np.arange(500), hit=0)
    assert np.isfinite(states).all()
    assert (states[:, 1] > 0.0).all()


def test_a_small_law_follows_chains_and_a_wrong_one_does_not(tmp_path):
    """At particles that spin forwards; equal laws exceed the bound in one of 8 with p = 0.008."""
    domain = {"alpha_deg": [2.0, 90.0], "speed": [20.0, 300.0], "extrapolate": True}
    changes = {
        "spin": True,
        "domain": domain | {"components": [*STATE, *WORKS]},
        "table": {"alpha_nodes_deg": [2.0, 90.0], "speed_nodes": [20.0, 300.0]}
        | {"spin_leaves": 3, "spin_groups": 4, "spin_experts": 8, "spin_rebounds": 24_000},
    }
    config = SPINNING.with_changes(changes)
    table = generate(config, tmp_path / "t.h5", conditions=0).table
    impacts, direct, bound = chain_sample(config, -0.3)
    assert bound < 0.065

    def drawn(turned):
        keys = {"seed": 3, "index": impacts.index, "hit": impacts.hit}
        return table.sample(impacts.alpha1, impacts.speed, spin=impacts.spin * turned, **keys)

    assert max(ks_distances(drawn([1.0, 1.0, 1.0]), direct)) < bound
    assert max(ks_distances(drawn([1.0, 1.0, -1.0]), direct)) > 2.0 * bound
    exchanged = drawn([1.0, 1.0, 1.0])[:, [7, 6]]
    assert min(ks_distances(exchanged, direct[:, 6:])) > 2.0 * bound


def test_an_interrupted_law_resumes(tmp_path, monkeypatch):
    whole, resumed = tmp_path / "whole.h5", tmp_path / "resumed.h5"
    calls = []

    def failing(*arguments):
        calls.append(arguments)
        if len(calls) == 2:
            raise RuntimeError("interrupted")
        return fit_leaf(*arguments)

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
    assert speed_coordinate(SPINNING) == (0.1, 0.61)
    constant = {"law": "constant", "value": 0.5, "source": "a test"}
    config = SPINNING.with_changes(
        {"pair": {"restitution": constant}, "domain": {"extrapolate": True}}
    )
    assert speed_coordinate(config).of(np.array([120.0])) == pytest.approx(0.5)
