"""Tables of spheres: draws are direct simulation, in every law, in Python, C and numba."""

import numpy as np
import pytest
from contact_law_samples import RESISTANCE, RESTITUTION
from refusals import refused

import sampler
from sampler.formats.channels import STATE, WORKS
from sampler.formats.hdf5 import write_table
from tablegen.config.config import load_config
from tablegen.simulation.direct import DirectModel
from tablegen.simulation.simulate import simulate
from tablegen.tables import spheres
from tablegen.tables.prune import pruned

KHARAZ = load_config("kharaz-2001")
REVERSING = RESISTANCE["coulomb"] | {"tangential_restitution": [0.44], "angle_deg": [50.0]}
LAWS = [*zip(RESTITUTION.values(), [*RESISTANCE.values(), REVERSING], strict=True)]


def with_laws(restitution, resistance, **domain):
    provenance = {"source": "made up", "valid_speed": [1.0, 1000.0]}
    pair = {
        "restitution": restitution | provenance,
        "resistance": resistance | {"source": "made up"},
    }
    return KHARAZ.with_changes({"pair": pair, "domain": {"speed": [10.0, 300.0], **domain}})


CONFIG = with_laws(RESTITUTION["tabulated"], REVERSING)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """The table of a pair, through a file."""
    path = tmp_path_factory.mktemp("spheres") / "t.h5"
    write_table(path, spheres.sphere_contents(CONFIG))
    assert path.stat().st_size < 32_000
    return sampler.load(path, outside="raise")


@pytest.mark.parametrize(("restitution", "resistance"), LAWS)
def test_draws_are_direct_simulation(restitution, resistance):
    contents = spheres.sphere_contents(with_laws(restitution, resistance))
    assert spheres.largest_difference(contents, 1) < spheres.ROUNDING
    contents["sphere/laws"][[2, 6, -1]] *= 1.001
    assert spheres.largest_difference(contents, 1) > 1e-6


@pytest.mark.parametrize("roughness", [None, 0.2])
def test_rebounds_are_those_of_the_direct_model(table, roughness):
    rng = np.random.default_rng(3)
    velocity = rng.uniform((-90.0, -90.0, -90.0), (90.0, -1.0, 90.0), (500, 3))
    impact = velocity, (0.1, 2.0, 0.3), 2e-5
    impact[0][velocity @ impact[1] >= 0.0] = (50.0, -30.0, 0.0)
    more = {"omega": rng.uniform(-4e6, 4e6, (500, 3)), "wall_velocity": (1.0, 2.0, 3.0)}
    more |= {"roughness": roughness, "seed": 5, "index": np.arange(500), "hit": 2}
    config = CONFIG.with_changes({"model": {"tolerance": 1e-14}})
    direct = DirectModel(config).rebound(*impact, **more)
    drawn = table.rebound(*impact, **more)
    np.testing.assert_allclose(drawn.velocity, direct.velocity, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(drawn.omega, direct.omega, rtol=1e-11, atol=1e-5)
    assert table.counts["speed"] == 0
    np.testing.assert_array_equal(table.grains(1, [3, 4]), [[4.0, 1.0, 1.0]] * 2)


def test_the_laws_of_mechanics_hold(table):
    """Angular momentum about the contact is kept, and energy does not grow, at any impact."""
    rng = np.random.default_rng(4)
    alpha1, spin = np.radians(rng.uniform(1e-6, 90.0, 10_000)), rng.normal(0.0, 3.0, (10_000, 3))
    after = table.sample(alpha1, 1e-3, spin=spin, seed=1, index=np.arange(10_000), hit=0)
    before = np.column_stack([np.cos(alpha1), -np.sin(alpha1), 0.0 * alpha1, spin])
    momenta = [
        np.column_stack([s[:, 2] + 0.4 * s[:, 3], 0.4 * s[:, 4], 0.4 * s[:, 5] - s[:, 0]])
        for s in (before, after)
    ]
    np.testing.assert_allclose(momenta[1], momenta[0], rtol=0.0, atol=1e-14)
    weights = np.array([1.0, 1.0, 1.0, 0.4, 0.4, 0.4])
    energies = [(s**2) @ weights for s in (before, after)]
    assert (energies[1] <= energies[0] * (1.0 + 1e-14)).all()
    assert (after[:, 1] > 0.0).all()


def test_energies_and_works_of_first_impacts():
    names = ["v", "rotational_energy", "collisions", "work_normal", "work_shear"]
    config = with_laws(RESTITUTION["power"], REVERSING, variables=names)
    for alpha1 in np.radians([0.2, 20.0, 70.0]):
        simulation = simulate(config, alpha1, 80.0, 1, seed=1)
        expected = [simulation.state[0, 1], simulation.energy[0, 1], 1.0, *simulation.work[0]]
        drawn = sampler.Table(spheres.sphere_contents(config)).sample(alpha1, 80.0, seed=1, index=0)
        np.testing.assert_allclose(drawn, expected, rtol=0.0, atol=1e-12)


def test_works_balance_with_spin():
    """Energies after and works make up the energy before, over m V^2 / 2."""
    rng = np.random.default_rng(8)
    alpha1, spin = np.radians(rng.uniform(1.0, 90.0, 100)), rng.normal(0.0, 3.0, (100, 3))
    config = with_laws(RESTITUTION["power"], REVERSING, variables=[*STATE, *WORKS])
    table = sampler.Table(spheres.sphere_contents(config))
    drawn = table.sample(alpha1, 80.0, spin=spin, seed=1, index=np.arange(100), hit=0)
    weights = np.array([1.0, 1.0, 1.0, 0.4, 0.4, 0.4])
    after = drawn[:, :6] ** 2 @ weights + drawn[:, 6:].sum(axis=1)
    np.testing.assert_allclose(after, 1.0 + 0.4 * (spin**2).sum(axis=1), rtol=1e-12)
    assert (drawn[:, 6:] >= 0.0).all()


def test_commands(call, refuse, tmp_path):
    table_path = tmp_path / "k.h5"
    for ended in (
        call("tablegen", "generate", "kharaz-2001", "--output", table_path, "--quiet"),
        call("tablegen", "validate", table_path, "--seed", 5),
    ):
        assert ended.status == 0
        assert "holds: draws differ from direct simulation by at most " in ended.out
    assert "spheres           laws of contact" in call("tablegen", "inspect", table_path).out
    assert '"spheres": true' in call("tablegen", "inspect", table_path, "--json").out
    flags = ("--alpha", 70, "--speed", 3.9, "--seed", 1, "--count", 2)
    here, there = tmp_path / "s.npz", tmp_path / "d.npz"
    simulated = call("tablegen", "simulate", "--pair", "kharaz-2001", *flags, "--output", here)
    assert (
        simulated.status
        == call("sampler", "draw", table_path, *flags, "--output", there).status
        == 0
    )
    states = (np.load(path)["state"] for path in (here, there))
    np.testing.assert_allclose(*states, rtol=0.0, atol=1e-12)
    for words in (["--details"], ["--accuracy", "nonsense"], ["--accuracy", ""]):
        assert refuse("tablegen", "validate", table_path, *words).endswith(
            "a table of spheres is exact; of all options, only --seed applies"
        )


def test_what_is_refused():
    field = "pair.resistance.tangential_restitution"
    refused(field, KHARAZ.pair.kernel_arguments, only_spheres=False)
    coarse = KHARAZ.with_changes({"model": {"contact_resolution": 0.05}})
    refused("model.contact_resolution", spheres.sphere_contents, coarse)
    refused("table", pruned, spheres.sphere_contents(KHARAZ), KHARAZ)
