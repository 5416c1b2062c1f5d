"""Example `cyclone`: the gas, flights between walls, energy kept at walls, and the command."""

import json

import cyclone
import numpy as np
import pytest
from cyclone import BODY, COLLECTED, CONE, CORE, FATES, FINDER, FLOW, HEIGHT, LID, RADIUS, TUBE
from scipy.integrate import solve_ivp
from tqdm import tqdm

from tablegen import DirectModel

NO_DRAG = np.array([[0.0, 1.0, 1.0, 1.0, 1.0, 1.0]])


def follow(rebound, model, count, seed):
    return cyclone.follow(rebound, model, count, seed, tqdm(disable=True))


def cylindrical(r, z):
    """Radial, tangential and axial velocity of the gas at a place on the x axis."""
    return cyclone.gas_velocity(r, 0.0, z)


@pytest.mark.parametrize("z", [0.05, 0.15, 0.3, 0.39])
@pytest.mark.parametrize("share", [0.2, 0.45, 0.6, 0.8, 0.95])
def test_gas_has_no_sources_but_the_inlet(z, share):
    """The divergence vanishes in the outer vortex and in the core below the vortex finder."""
    r, h = share * cyclone.wall_radius(z), 1e-6
    if r < CORE and z < FINDER:
        pytest.skip("inside the vortex finder")
    radial = [(r + d) * cylindrical(r + d, z)[0] / r for d in (-h, h)]
    axial = [cylindrical(r, z + d)[2] for d in (-h, h)]
    terms = (radial[1] - radial[0]) / (2.0 * h), (axial[1] - axial[0]) / (2.0 * h)
    assert abs(sum(terms)) < 1e-3 * max(1.0, *map(abs, terms))


def test_gas_flows_along_walls_and_turns_as_barth_says():
    for z in (0.2, 0.3, 0.39):
        radial, _, axial = cylindrical(cyclone.wall_radius(z) * (1.0 - 1e-9), z)
        slope = cyclone.SLOPE if z > cyclone.CYLINDER else 0.0
        assert radial == pytest.approx(axial * slope, abs=1e-6)
    for z in (0.01, 0.1):
        assert cylindrical(CORE * (1.0 + 1e-9), z)[0] == pytest.approx(0.0, abs=1e-6)
        through = -cylindrical(RADIUS, z)[0] * 2.0 * np.pi * RADIUS * FINDER
        assert through == pytest.approx(FLOW)
    # angular momentum at the core over that at the wall
    ratio = cylindrical(CORE, 0.2)[1] * CORE / (cylindrical(RADIUS, 0.2)[1] * RADIUS)
    assert ratio == pytest.approx(1.0 / (1.0 + cyclone.LOSS))


@pytest.mark.parametrize(
    ("place", "velocity", "wall"),
    [
        ((0.06, 0.0, 0.05), (20.0, 5.0, 1.0), BODY),
        ((0.06, 0.0, 0.35), (20.0, 5.0, 1.0), CONE),
        ((0.06, 0.0, 0.05), (-20.0, 1.0, 1.0), TUBE),
        ((0.06, 0.0, 0.05), (1.0, 1.0, -20.0), LID),
        ((0.06, 0.0, 0.35), (0.0, 1.0, 20.0), COLLECTED),
        ((0.03, 0.0, 0.13), (0.0, 1.0, -20.0), cyclone.ESCAPED),
    ],
)
def test_without_gas_grains_fall_freely_to_the_wall_ahead(place, velocity, wall):
    states = np.array([[*place, *velocity]])
    ends, normals, times, _ = cyclone.fly_all(states, NO_DRAG, np.ones(1))
    assert ends[0] == wall
    time = times[0]
    fallen = np.array([0.0, 0.0, 0.5 * cyclone.GRAVITY * time**2])
    expected = np.array(place) + time * np.array(velocity) + fallen
    np.testing.assert_allclose(states[0, :3], expected, atol=1e-12)
    np.testing.assert_allclose(states[0, 3:], [*velocity[:2], velocity[2] + 9.81 * time])
    if wall in (BODY, CONE, TUBE, LID):
        assert np.linalg.norm(normals[0]) == pytest.approx(1.0)
        assert normals[0] @ states[0, 3:] < 0.0
        r, z = np.hypot(*states[0, :2]), states[0, 2]
        edge = {BODY: RADIUS, CONE: cyclone.wall_radius(z), TUBE: CORE, LID: r}[wall]
        assert r == pytest.approx(edge, rel=1e-9)


def test_flights_are_those_of_an_independent_integration():
    drags = cyclone.drag_of(np.array([20e-6]), np.array([0.78]))
    start = np.array([[0.08, 0.0, 0.15, -10.0, 30.0, 2.0]])
    a, b, c, d = drags[0, 2:]

    def slope(_, p):
        slip = np.array(cyclone.gas_velocity(*p[:3])) - p[3:]
        reynolds = 1.16 * 20e-6 * np.linalg.norm(slip) / 1.85e-5
        coefficient = 24.0 / reynolds * (1.0 + a * reynolds**b) + c / (1.0 + d / reynolds)
        rate = 0.75 * coefficient * 1.16 * np.linalg.norm(slip) / (3950.0 * 20e-6)
        return *p[3:], *(rate * slip + [0.0, 0.0, 9.81])

    def surface(_, p):
        return np.hypot(p[0], p[1]) - cyclone.wall_radius(p[2])

    surface.terminal = True
    solution = solve_ivp(slope, (0.0, 1.0), start[0], events=surface, rtol=1e-9, atol=1e-12)
    ends, _, times, _ = cyclone.fly_all(start, drags, np.ones(1))
    assert ends[0] in (BODY, CONE)
    np.testing.assert_allclose(times, solution.t_events[0], rtol=1e-3)
    np.testing.assert_allclose(start, solution.y_events[0], rtol=2e-3, atol=1e-4)


def test_a_curved_wall_presses_by_the_path_round_it():
    """Two grains fall on the wall without gas: one straight, one also round it at 30 m/s."""
    for place, radius, sign in ((0.0999, RADIUS, 1.0), (0.0501, CORE, -1.0)):
        for around in (0.0, 30.0):
            states = np.array([[place, 0.0, 0.05, sign * 20.0, around, 0.0]])
            *_, pressing = cyclone.fly_all(states, NO_DRAG, np.ones(1))
            # the velocity turns a little on the way
            assert pressing[0] == pytest.approx(sign * around**2 / radius, rel=0.05)
    states = np.array([[0.08, 0.0, 1e-4, 0.0, 30.0, -1.0]])
    *_, pressing = cyclone.fly_all(states, NO_DRAG, np.ones(1))
    assert pressing[0] == pytest.approx(-cyclone.GRAVITY)


def test_every_grain_ends_and_walls_take_energy_at_every_hit(config):
    model, hits, losses = DirectModel(config), [], []

    def rebound(velocity, normal, half_size, *, omega, inertia, index, hit, **keys):
        after = model.rebound(
            velocity, normal, half_size, omega=omega, inertia=inertia, index=index, hit=hit, **keys
        )
        energy = [
            0.5 * (v**2).sum(axis=1) + cyclone.spin_energy(spin, k, half_size)
            for v, spin, k in ((velocity, omega, inertia), after)
        ]
        hits.append(hit)
        losses.append((energy[0] - energy[1]) / energy[0])
        return after

    result = follow(rebound, model, 60, seed=1)
    assert np.isin(result.fate, list(FATES.values())).all()
    assert sum((result.fate == fate).sum() for fate in FATES.values()) == 60
    assert result.hits.sum() == sum(map(len, hits))
    assert np.concatenate(losses).min() > -1e-9
    assert (result.taken > 0.0).all()
    ended = np.isin(result.fate, [COLLECTED, cyclone.LOST, cyclone.ESCAPED])
    assert (result.time[ended] > 1e-3).all()
    assert result.time.max() < 1.01 * cyclone.TIME_LIMIT
    assert cyclone.wear_by_height(result)[0] @ np.diff(cyclone.BINS) == pytest.approx(
        cyclone.columns_of(result, slice(None))["Oka, mm³/kg"][0]
    )


def test_a_law_that_is_direct_simulation_gives_its_columns(config):
    """Results agree within four standard errors; those of a law that ignores spins do not."""
    model = DirectModel(config)

    def no_spin(velocity, normal, half_size, *, omega, inertia, **keys):
        return model.rebound(velocity, normal, half_size, omega=0.0 * omega, **keys)

    names = "direct", "again", "no spin"
    laws = dict(zip(names, (model.rebound, model.rebound, no_spin), strict=True))
    results = {name: follow(law, model, 400, 7 + k) for k, (name, law) in enumerate(laws.items())}
    rows = cyclone.tables_of(results)["all shapes, 14 to 37 µm"]
    off = {name: cyclone.differences(row, rows["direct"]) for name, row in rows.items()}
    assert off["direct"] == (0.0, [])
    assert off["again"][0] < 4.0 < off["no spin"][0]
    assert "residence" in off["no spin"][1]


def test_command_prints_draws_and_writes(tmp_path, capsys):
    picture, numbers = tmp_path / "c.png", tmp_path / "c.json"
    cyclone.main(["--grains", "40", "--picture", str(picture), "--json", str(numbers)])
    printed = capsys.readouterr().out
    for law in (cyclone.DIRECT, cyclone.TABLE, cyclone.COMPACT, cyclone.WITHOUT_SPIN):
        assert f"\n| {law} | " in printed
    assert picture.read_bytes().startswith(b"\x89PNG")
    columns = json.loads(numbers.read_text())["columns"]["all shapes, 5 to 100 µm"]
    assert columns["table"]["hits"][0] > 5.0
    assert json.loads(numbers.read_text())["height, m"][-1] == pytest.approx(HEIGHT)
