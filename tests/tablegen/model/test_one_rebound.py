"""A rebound in the user's own compiled code: the bits of many, and no wrong argument."""

import numba
import numpy as np
import pytest
from crowds import CROWD
from motion_fixtures import CONFIG
from numba.core.errors import TypingError

import tablegen
from sampler.errors import HALF_SIZE, NOT_APPROACHING, NOT_FINITE, OK
from tablegen.model.impacts import OUT_OF_BOUNDS, TURNS_TOO_OFTEN
from tablegen.model.orientation import ORIENTATION_NOT_USABLE
from tablegen.model.random_particles import GRAIN_NOT_USABLE

MODEL = tablegen.DirectModel(CONFIG, CROWD)
AT_REST = (0.0, 0.0, 0.0)


@numba.njit
def track(arrays, velocity, normal, omega, own, orientation, work_size):
    """Rebounds of particles at their hit 3, in an ordinary compiled function; turns them after."""
    n = len(velocity)
    status, after, work = np.empty(n, dtype=np.int64), np.empty((n, 6)), np.empty(work_size)
    for k in range(n):
        v = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        e_y = normal[k, 0], normal[k, 1], normal[k, 2]
        w = omega[k, 0], omega[k, 1], omega[k, 2]
        grain = tablegen.grain(arrays, 7, k, 0 if own else 3)
        turned, still = orientation[k], (0.0, 0.0, 0.0)
        status[k] = tablegen.rebound(
            arrays, v, e_y, 1e-5, still, w, grain, turned, 7, k, 3, work, after[k]
        )
        w = after[k, 3], after[k, 4], after[k, 5]
        flight, w = tablegen.tumble(arrays, turned, w, grain, 1e-7 * k, work)
        status[k], after[k, 3:] = min(status[k], flight), w
    return status, after


@pytest.mark.processor
@pytest.mark.parametrize("omega_is", ["mean", "departure"])
@pytest.mark.parametrize("oriented", [True, False])
def test_bits_are_those_of_eight_at_a_time(oriented, omega_is):
    """Of a rebound and of the flight after it, with orientations given or drawn by the keys."""
    rng = np.random.default_rng(2)
    model = tablegen.DirectModel(CONFIG.with_changes({"domain": {"omega": omega_is}}), CROWD)
    grain = "own" if oriented else "fresh"
    normal, velocity = rng.standard_normal((2, 1000, 3))
    velocity *= -80.0 * np.sign(np.einsum("nk,nk->n", velocity, normal))[:, None]
    velocity[:100] = -80.0 * normal[:100]
    omega = rng.normal(0.0, 5e6, (1000, 3)) * (rng.random((1000, 1)) < 0.7)
    turned = rng.normal(size=(1000, 4)) if oriented else np.zeros((1000, 4))
    keys = {"seed": 7, "index": range(1000), "hit": 3, "grain": grain}
    keys |= {"orientation": turned.copy()} if oriented else {}
    status, after = track(model.arrays, velocity, normal, omega, oriented, turned, model.work_size)
    assert (status == OK).all()
    expected = model.rebound(velocity, normal, 1e-5, omega=omega, **keys)
    grains = [tablegen.grain(model.arrays, 7, k, 0 if oriented else 3) for k in range(1000)]
    flown = model.tumble(
        expected.orientation, expected.omega, grains, 1e-5, 1e-7 * np.arange(1000.0)
    )
    np.testing.assert_array_equal(after[:, :3], expected.velocity)
    np.testing.assert_array_equal(turned, flown[0])
    np.testing.assert_array_equal(after[:, 3:], flown[1])
    assert (expected.omega != flown[1]).any() == (omega_is == "departure")


def rebound(**changes):
    """Status and outcome of a rebound from Python, with some arguments changed."""
    arguments = {
        "arrays": MODEL.arrays,
        "velocity": (10.0, -20.0, 0.0),
        "normal": (0.0, 1.0, 0.0),
        "half_size": 1e-5,
        "wall_velocity": AT_REST,
        "omega": AT_REST,
        "grain": (1.0, 0.8, 0.7),
        "orientation": np.zeros(4),
        "seed": 1,
        "index": 2,
        "hit": 0,
        "work": np.empty(MODEL.work_size),
        "out": np.zeros(6),
    } | changes
    return tablegen.rebound(*arguments.values()), arguments["out"]


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"velocity": (1.0, 2.0, 0.0)}, NOT_APPROACHING),
        ({"half_size": 0.99e-9}, HALF_SIZE),
        ({"half_size": 0.101}, HALF_SIZE),
        ({"omega": (0.0, np.nan, 0.0)}, NOT_FINITE),
        ({"omega": (0.0, 0.0, 1e14)}, TURNS_TOO_OFTEN),
        ({"velocity": (0.0, -1e-9, 0.0)}, OUT_OF_BOUNDS),
        ({"velocity": (0.0, -1e9, 0.0)}, OUT_OF_BOUNDS),
        ({"velocity": (1.0, -1e-9, 0.0)}, OUT_OF_BOUNDS),
        ({"grain": (1.0, 1.5, 0.7)}, GRAIN_NOT_USABLE),
        ({"grain": (5.0, 0.8, 0.7)}, GRAIN_NOT_USABLE),
        ({"orientation": np.array([0.0, np.nan, 0.0, 0.0])}, ORIENTATION_NOT_USABLE),
        ({"orientation": np.full(4, 1e-200)}, ORIENTATION_NOT_USABLE),
    ],
)
def test_bad_numbers_give_a_code_and_write_nothing(changes, code):
    orientation = changes.get("orientation", np.zeros(4)).copy()
    status, out = rebound(**{"orientation": orientation} | changes)
    assert status == code
    assert not out.any()
    np.testing.assert_array_equal(changes.get("orientation", np.zeros(4)), orientation)
    assert rebound()[0] == OK


@pytest.mark.parametrize(
    ("changes", "code"),
    [
        ({"omega": (0.0, np.nan, 0.0)}, NOT_FINITE),
        ({"time": np.inf}, NOT_FINITE),
        ({"time": -1e-9}, TURNS_TOO_OFTEN),
        ({"time": 1.1}, TURNS_TOO_OFTEN),
        ({"grain": (1.0, 1.5, 0.7)}, GRAIN_NOT_USABLE),
        ({"orientation": np.zeros(4)}, ORIENTATION_NOT_USABLE),
    ],
)
def test_bad_numbers_of_a_flight_give_a_code_and_write_nothing(changes, code):
    given = {"orientation": np.array([0.6, 0.0, -0.8, 0.0]), "omega": (0.0, 1e6, 0.0)}
    given |= {"grain": (1.0, 0.8, 0.7), "time": 1e-3, "work": np.empty(MODEL.work_size)} | changes
    before = given["orientation"].copy()
    status, omega = tablegen.tumble(MODEL.arrays, *given.values())
    assert status == code
    np.testing.assert_array_equal(omega, given["omega"])
    np.testing.assert_array_equal(before, given["orientation"])


def test_short_arrays_are_refused():
    with pytest.raises(ValueError, match=r"^work: got too few numbers, allowed: the model's work_"):
        rebound(work=np.empty(MODEL.work_size - 1))
    with pytest.raises(ValueError, match=r"^out: got fewer than 6 numbers, allowed: shape \(6,\)$"):
        rebound(out=np.zeros(5))
    with pytest.raises(ValueError, match=r"^orientation: got fewer than 4 numbers, allowed: shape"):
        rebound(orientation=np.zeros(3))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("work", np.empty(2 * MODEL.work_size)[::2]),
        ("work", np.empty(MODEL.work_size, dtype=np.float32)),
        ("out", np.zeros((1, 6))),
        ("orientation", (1.0, 0.0, 0.0, 0.0)),
        ("index", 2.0),
        ("velocity", np.zeros(3)),
        ("omega", np.zeros(3)),
    ],
)
def test_wrong_types_are_refused_while_compiling(name, value):
    with pytest.raises(TypingError, match=f"{name}: got .*, allowed: "):
        rebound(**{name: value})
