"""Tables of scenes from the configuration to the draw: only the columns asked for, all of them."""

import numpy as np
import pytest
from corrupt_tables import declaring, shifted_speeds
from tiny_tables import MEASURED, TINY

import sampler
from sampler.formats.channels import WORKS, channels_for
from sampler.formats.hdf5 import read_table, write_table
from tablegen.accuracy.metrics import ks_distances
from tablegen.accuracy.validate import validate
from tablegen.simulation.scene_variables import simulated_variables
from tablegen.simulation.simulate import simulate
from tablegen.tables.generate import generate

pytestmark = pytest.mark.usefixtures("quick_classifier")

MANY = ("u", "v", "w", "rotational_energy", "collisions", *WORKS)
SCENES = {
    "plane": ({"dimension": 2}, ("u", "v", "omega_z")),
    "many": ({"components": list(MANY)}, MANY),
}
#: A node, where there is no interpolation, and a condition between the nodes.
NODE, BETWEEN = (45.0, 60.0), (39.0, 120.0)
N = 20_000
#: The gap between two empirical distribution functions of N and the law of a node from 6,000
#: states is a Brownian bridge of this variance; eight components exceed the bound with
#: probability 1e-6. At most 0.004 for knots at a node, and 0.015 for the distance of the nodes.
VARIANCE = 2.0 / N + 1.0 / TINY.table.samples_per_node
KS_BOUND = np.sqrt(0.5 * np.log(16.0 / 1e-6) * VARIANCE) + 0.004


class Scene:
    def __init__(self, name, path):
        changes, self.columns = SCENES[name]
        # without the mirror, so that probabilities of reflection are fitted
        self.config = TINY.with_changes({"domain": changes, "table": {"mirror": False}})
        self.path = path
        generate(self.config, path, conditions=1, samples=MEASURED)
        self.table = sampler.load(path)

    def drawn(self, alpha_deg, speed):
        return self.table.sample(np.radians(alpha_deg), speed, seed=8, index=np.arange(N))

    def direct(self, alpha_deg, speed):
        keys = {"seed": 4, "stream": 7, "threads": 1}
        simulation = simulate(self.config, np.radians(alpha_deg), speed, N, **keys)
        return simulated_variables(simulation, self.columns)


@pytest.fixture(scope="module", params=SCENES)
def scene(request, tmp_path_factory):
    return Scene(request.param, tmp_path_factory.mktemp("scene") / f"{request.param}.h5")


def test_file_holds_the_columns_asked_for(scene):
    contents = read_table(scene.path)
    assert contents.variables == scene.table.columns == scene.columns
    assert contents.channels == contents.marginals == channels_for(scene.columns)
    channels = len(contents.channels)
    assert contents["marginals/quantiles"].shape[3] == channels
    assert contents["dependence/cholesky"].shape[-1] == channels * (channels + 1) // 2
    assert contents["accuracy/ks"].shape == (1, len(scene.columns))
    # reflection is fitted where a channel has a sign
    assert contents["dependence/reflection"].any() == ("w_hat" in contents.channels)


def test_columns_are_those_of_the_simulation(scene):
    drawn, direct = scene.drawn(*NODE), scene.direct(*NODE)
    assert drawn.shape == direct.shape
    assert ks_distances(drawn, direct).max() < KS_BOUND
    # Refused: another angle, each column moved by 0.3 of its width, and columns exchanged.
    assert ks_distances(scene.drawn(35.0, NODE[1]), direct).max() > KS_BOUND
    moved = drawn + 0.3 * drawn.std(axis=0)
    assert (ks_distances(moved, direct) > KS_BOUND).all()
    assert (ks_distances(np.roll(drawn, 1, axis=1), direct) > KS_BOUND).sum() >= 2
    between = scene.direct(*BETWEEN)
    assert ks_distances(scene.drawn(*BETWEEN), between).max() < KS_BOUND + 0.015
    assert ks_distances(drawn, between).max() > KS_BOUND + 0.015


def test_draws_are_possible(scene):
    rng = np.random.default_rng(5)
    alpha1, speed = np.radians(rng.uniform(35.0, 45.0, N)), rng.uniform(60.0, 300.0, N)
    states = scene.table.sample(alpha1, speed, seed=9, index=np.arange(N))
    found = dict(zip(scene.columns, states.T, strict=True))
    assert np.isfinite(states).all()
    assert (found["v"] > 0.0).all()
    moving = sum(np.square(found[name]) for name in ("u", "v", "w") if name in found)
    assert (moving + found.get("rotational_energy", 0.0) < 1.0).all()
    if "collisions" in found:
        np.testing.assert_array_equal(found["collisions"], np.floor(found["collisions"]))
        assert found["collisions"].min() == 1.0
        assert (found["collisions"] > 3.0).any()
    if "work_normal" in found:
        # the works are the energy that the rebound lost
        kept = moving + found["rotational_energy"]
        lost = found["work_normal"] + found["work_shear"]
        np.testing.assert_allclose(kept + lost, 1.0, rtol=0.0, atol=1e-14)
        assert min(found[name].min() for name in WORKS) >= 0.0


def test_validation_passes_it_and_refuses_another_speeds_law(scene, tmp_path):
    """Of a right table the test of the nodes says otherwise once in 200 times, at most."""
    right, wrong = tmp_path / "right.h5", tmp_path / "wrong.h5"
    contents = declaring(read_table(scene.path), ks=0.06)
    write_table(right, contents)
    write_table(wrong, shifted_speeds(contents))
    passed = validate(right, conditions=1, samples=4_000, seed=1)
    assert passed.missed == []
    assert passed.comparisons[0].variables == scene.columns
    missed = validate(wrong, conditions=2, samples=40_000, seed=1).missed
    assert "ks" in [number.name for number in missed]


def works_differ(drawn, direct):
    """Whether two samples of both works differ in a marginal or in their dependence."""
    gap = np.corrcoef(drawn.T)[0, 1] - np.corrcoef(direct.T)[0, 1]
    # five errors of 20,000 states and of a node's 6,000, and 0.03 for 16 components
    return ks_distances(drawn, direct).max() > KS_BOUND or abs(gap) > 0.03 + 5.0 * VARIANCE**0.5


@pytest.mark.parametrize("scene", ["many"], indirect=True)
def test_joint_law_of_the_works_is_that_of_the_simulation(scene):
    works, truth = scene.drawn(*NODE)[:, 5:], scene.direct(*NODE)[:, 5:]
    assert not works_differ(works, truth)
    # Refused: shares of other particles, and works that are exchanged.
    lost = works.sum(axis=1)
    share = np.random.default_rng(1).permutation(works[:, 0] / lost)
    assert works_differ(np.column_stack([share * lost, (1.0 - share) * lost]), truth)
    assert works_differ(works[:, ::-1], truth)
