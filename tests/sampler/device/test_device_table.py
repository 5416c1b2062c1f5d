"""Draws on arrays of a device are those of the table, and refuse what it refuses.

CuPy is a stand-in, `cupy_on_host`, and so are the kernels' threads; the program is the one that
CuPy gets.
"""

import sys
from pathlib import Path

import numpy as np
import pytest

import sampler
from sampler.errors import InputError, OutsideTableWarning

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "embedding"))
import cupy_on_host as cupy

pytestmark = pytest.mark.filterwarnings("ignore::sampler.OutsideTableWarning")
VECTORS = Path(__file__).resolve().parents[2] / "vectors"


@pytest.fixture(scope="module", autouse=True)
def stand_in(tmp_path_factory):
    """`import cupy` gives the stand-in."""
    with cupy.in_place_of_cupy(tmp_path_factory.mktemp("programs")):
        yield


def load(name, **keywords):
    return sampler.load(VECTORS / f"{name}.h5", **keywords)


@pytest.fixture(scope="module")
def spin():
    """A table with a spin law, on the host and on the device."""
    table = load("spin")
    return table, table.to_device()


def on_device(arguments):
    """The same arguments, arrays on the device."""
    return {
        name: cupy.asarray(value) if isinstance(value, np.ndarray) else value
        for name, value in arguments.items()
    }


def conditions(n, seed=1):
    rng = np.random.default_rng(seed)
    return {
        "alpha1": rng.uniform(0.4, 1.2, n),
        "speed": rng.uniform(55.0, 115.0, n),
        "index": rng.integers(0, 2**64, n, dtype=np.uint64),
        "hit": rng.integers(0, 2**32, n, dtype=np.uint32),
        "seed": 5,
    }


def impacts(n, seed=1):
    rng = np.random.default_rng(seed)
    return {
        "velocity": rng.uniform([20.0, -90.0, -9.0], [80.0, -60.0, 9.0], (n, 3)),
        "normal": np.array([0.0, 2.0, 0.1]),
        "half_size": rng.uniform(1e-6, 1e-4, n),
        "index": rng.integers(0, 2**64, n, dtype=np.uint64),
        "hit": rng.integers(0, 2**32, n, dtype=np.uint32),
        "seed": 5,
    }


@pytest.mark.parametrize("name", ["full", "plane", "all-eight", "works", "pruned"])
def test_draws_have_the_bits_of_the_table(name):
    table, given = load(name), conditions(300)
    found = table.to_device().sample(**on_device(given))
    assert isinstance(found, cupy.ndarray)
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given))


@pytest.mark.parametrize("grain", ["own", "fresh"])
def test_draws_with_spin_have_the_bits_of_the_table(spin, grain):
    table, device = spin
    given = conditions(100) | {"spin": np.random.default_rng(2).standard_normal((100, 3))}
    found = device.sample(**on_device(given), grain=grain)
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given, grain=grain))


@pytest.mark.parametrize("wall", [{}, {"wall_velocity": np.array([1.0, 5.0, 0.0])}])
@pytest.mark.parametrize("omega", [False, True])
@pytest.mark.parametrize("rough", [None, 0.1, "rows"])
def test_rebounds_are_those_of_the_table(spin, wall, omega, rough):
    table, device = spin
    given, rng = impacts(50) | wall, np.random.default_rng(3)
    if omega:
        given["omega"] = rng.standard_normal((50, 3)) * 1e6
    if rough is not None:
        given["roughness"] = rng.uniform(0.0, 0.3, 50) if rough == "rows" else rough
    # the C library's functions differ in the last digits, which a feature in single precision has
    precision = {"rtol": 0.0, "atol": 1e-5 if omega else 1e-11}
    pairs = zip(device.rebound(**on_device(given)), table.rebound(**given), strict=True)
    for found, expected in pairs:
        size = np.abs(expected).max()
        np.testing.assert_allclose(cupy.asnumpy(found) / size, expected / size, **precision)


def test_numbers_in_single_precision_are_rounded_once():
    table, given = load("full"), conditions(300)
    given |= {name: given[name].astype(np.float32) for name in ("alpha1", "speed")}
    found = table.to_device("float32").sample(**on_device(given))
    assert found.dtype == np.float32
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given).astype(np.float32))


def test_arguments_broadcast_and_may_be_of_the_host():
    table = load("full")
    device = table.to_device()
    given = {"alpha1": np.array([[0.5], [0.9]]), "speed": 100.0, "seed": 1, "index": [3, 4, 5]}
    found = device.sample(**given, hit=cupy.asarray(np.array([[0], [1]])))
    assert found.shape == (2, 3, 6)
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given, hit=[[0], [1]]))
    one = device.rebound([60.0, -60.0, 0.0], [0.0, 1.0, 0.0], 1e-5, seed=1, index=2)
    assert one.velocity.shape == one.omega.shape == (3,)


def test_more_rows_than_threads():
    table, given = load("plane"), conditions(4200)
    device = table.to_device()
    cupy.RawModule.launches.clear()
    found = device.sample(**on_device(given))
    assert cupy.RawModule.launches == [("rbt_draw_kernel", 32, 128)]
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given))


def test_no_rows():
    device = load("plane").to_device()
    assert device.sample(np.zeros(0), 100.0, seed=1, index=0).shape == (0, 3)


def test_a_population_is_that_of_the_table():
    table = load("spin", population={"shapes": {"sphere": 1.0}})
    given = conditions(50)
    found = table.to_device().sample(**on_device(given))
    np.testing.assert_array_equal(cupy.asnumpy(found), table.sample(**given))


def test_draws_outside_are_counted_and_told_once():
    table, given = load("full"), conditions(40)
    given["speed"][[7, 30]] = 500.0
    device = table.to_device()
    for calls in (1, 2):
        with pytest.warns(OutsideTableWarning) if calls == 1 else pytest.MonkeyPatch.context():
            device.sample(**on_device(given))
        assert device.clamped == 2 * calls
    with pytest.warns(OutsideTableWarning):
        table.sample(**given)
    assert device.extrapolated == 2 * table.extrapolated


def same_refusal(name, call, **keywords):
    """The line with which host and device refuse."""
    table = load(name, **keywords)
    lines = []
    for drawer, arrays in ((table, dict), (table.to_device(), on_device)):
        with pytest.raises(InputError) as refused:
            call(drawer, arrays)
        lines.append(str(refused.value))
    assert lines[0] == lines[1]
    return lines[0]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("alpha1", [0.5, np.nan]), ("alpha1", [0.5, 2.0]), ("speed", [100.0, 0.0]),
        ("speed", [True, True]), ("speed", ["a", "b"]), ("index", [0, -1]), ("index", [0.0, 0.5]),
        ("hit", [0, 2**32]), ("spin", [[0.0, 0.0, 1.0]] * 2), ("speed", [100.0] * 3),
    ],
)  # fmt: skip
def test_draws_are_refused_as_by_the_table(name, values):
    given = {"alpha1": np.full(2, 0.5), "speed": 100.0, "seed": 1, "index": np.arange(2)}
    given[name] = np.array(values)
    line = same_refusal("full", lambda drawer, arrays: drawer.sample(**arrays(given)))
    assert line.startswith(f"{name}: got")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("velocity", np.inf), ("velocity", 60.0), ("normal", 0.0), ("half_size", -1.0),
        ("roughness", 0.6), ("wall_velocity", -500.0),
    ],
)  # fmt: skip
def test_rebounds_are_refused_as_by_the_table(name, value):
    rows = {
        "velocity": np.tile([60.0, -60.0, 0.0], (5, 1)), "normal": np.tile([0.0, 1.0, 0.0], (5, 1)),
        "half_size": np.full(5, 1e-5), "roughness": np.zeros(5), "wall_velocity": np.zeros((5, 3)),
    }  # fmt: skip
    rows[name][3] = value
    keys = {"seed": 1, "index": 0}
    line = same_refusal("full", lambda drawer, arrays: drawer.rebound(**arrays(rows), **keys))
    assert line.startswith(name if name != "wall_velocity" else "velocity")
    assert "at index 3" in line


def test_outside_is_refused_where_the_table_refuses_it():
    given = conditions(5)
    given["speed"][2], given["alpha1"][4] = 500.0, np.nan
    line = same_refusal(
        "full", lambda drawer, arrays: drawer.sample(**arrays(given)), outside="raise"
    )
    assert line.startswith("speed: got 500 at index 2")


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (
            lambda table: table.to_device("float16"),
            "dtype: got 'float16', allowed: 'float64', 'float32'",
        ),
        (
            lambda table: table.to_device().sample(0.5, 100.0, seed=1, index=0, grain=np.zeros(3)),
            "grain: got ndarray, allowed: 'own', 'fresh'",
        ),
        (
            lambda table: table.to_device().sample(0.5, 100.0, index=0),
            "seed: is missing, allowed: seed=, index= and hit=, or rng= and size= in their place",
        ),
    ],
)  # fmt: skip
def test_what_only_a_device_refuses(call, line):
    with pytest.raises(InputError) as refused:
        call(load("full"))
    assert str(refused.value) == line


def test_without_cupy_or_a_gpu_one_line_says_so(monkeypatch):
    table = load("full")
    monkeypatch.setattr(cupy.cuda.runtime, "getDeviceCount", lambda: 0)
    with pytest.raises(
        InputError, match=r"^to_device: got no GPU, allowed: one that CuPy can use$"
    ):
        table.to_device()

    def fail():
        raise RuntimeError("cudaErrorInsufficientDriver: CUDA driver version is insufficient")

    monkeypatch.setattr(cupy.cuda.runtime, "getDeviceCount", fail)
    with pytest.raises(InputError, match=r"got no GPU \(cudaErrorInsufficientDriver\), allowed"):
        table.to_device()
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(InputError, match=r"^to_device: CuPy is not installed, allowed after: pip"):
        table.to_device()
