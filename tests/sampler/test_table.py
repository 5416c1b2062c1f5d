"""The Table class: keys, shapes, threads, ranges, and what it refuses."""

import threading
import warnings
from dataclasses import replace

import numpy as np
import pytest
from synthetic_table import make_contents

import sampler
from sampler import InputError, OutsideTableWarning
from sampler.arguments import Keys, broadcast

pytestmark = pytest.mark.processor

N = 50_000
RNG = np.random.default_rng(1)
IMPACT = {"velocity": [60.0, -80.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}
IMPACT["grain"] = "fresh"


def _conditions(n=N, seed=1, index=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.36, np.pi / 2, n), rng.uniform(50.0, 300.0, n)


def test_same_keys_same_states_for_any_threads_and_batches(table):
    alpha1, speed = _conditions()
    index = np.random.default_rng(2).permutation(N).astype(np.uint64)
    whole = table.sample(alpha1, speed, seed=7, index=index, threads=1)
    for threads in (None, 2, 3, 7):
        again = table.sample(alpha1, speed, seed=7, index=index, threads=threads)
        np.testing.assert_array_equal(again, whole)
    order = np.random.default_rng(3).permutation(N)
    permuted = table.sample(alpha1[order], speed[order], seed=7, index=index[order])
    np.testing.assert_array_equal(permuted, whole[order])
    part = slice(100, 131)
    np.testing.assert_array_equal(
        table.sample(alpha1[part], speed[part], seed=7, index=index[part]), whole[part]
    )


def test_rebound_is_the_same_for_any_threads(table):
    velocity = np.random.default_rng(4).standard_normal((N, 3)) * 100.0
    velocity[:, 1] = -np.abs(velocity[:, 1])
    given = {"grain": "fresh", "seed": 3, "index": range(N)}
    one = table.rebound(velocity, [0, 1, 0], 1e-5, threads=1, **given)
    for threads in (None, 5):
        many = table.rebound(velocity, [0, 1, 0], 1e-5, threads=threads, **given)
        np.testing.assert_array_equal(many[0], one[0])
        np.testing.assert_array_equal(many[1], one[1])


def test_each_key_changes_every_state(table):
    base = table.sample(0.7, 120.0, seed=1, index=np.arange(1000), hit=2)
    for other in (
        table.sample(0.7, 120.0, seed=2, index=np.arange(1000), hit=2),
        table.sample(0.7, 120.0, seed=1, index=np.arange(1000) + 2**32, hit=2),
        table.sample(0.7, 120.0, seed=1, index=np.arange(1000), hit=3),
    ):
        assert (other != base).any(axis=1).all()
        # Independent too: 6 correlations below 6.1 standard errors, false alarm 1e-8.
        r = [np.corrcoef(base[:, k], other[:, k])[0, 1] for k in range(6)]
        assert np.abs(r).max() < 6.1 / np.sqrt(1000)


class TestGenerator:
    """For people who want random numbers and not keys."""

    def test_calls_differ_and_equal_generators_do_not(self, table):
        one, two = np.random.default_rng(1), np.random.default_rng(1)
        first = [table.sample(0.7, 100.0, size=50, rng=one) for _ in range(2)]
        second = [table.sample(0.7, 100.0, size=50, rng=two) for _ in range(2)]
        np.testing.assert_array_equal(first, second)
        assert (first[0] != first[1]).any(axis=1).all()
        seed = np.random.default_rng(1).integers(2**64, dtype=np.uint64)
        keyed = table.sample(0.7, 100.0, seed=seed, index=range(50), hit=0)
        np.testing.assert_array_equal(first[0], keyed)

    def test_rebounds_take_it_too(self, table):
        impact = ([60.0, -80.0, 0.0], [0, 1, 0], 1e-5)
        rng = np.random.default_rng(1)
        first, second = (
            table.rebound(*impact, size=(4, 5), rng=rng, grain="fresh") for _ in range(2)
        )
        assert first.velocity.shape == first.omega.shape == (4, 5, 3)
        assert (first.velocity != second.velocity).all()
        seed = np.random.default_rng(1).integers(2**64, dtype=np.uint64)
        index = np.arange(20).reshape(4, 5)
        keyed = table.rebound(*impact, seed=seed, index=index, grain="fresh")
        np.testing.assert_array_equal(first, keyed)


KEYS = "allowed: seed=, index= and hit=, or rng= and size= in their place"


@pytest.mark.parametrize("method", ["sample", "rebound"])
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, f"seed: is missing, {KEYS}"),
        ({"seed": 1}, f"index: is missing, {KEYS}"),
        ({"seed": 1, "hit": 0}, f"index: is missing, {KEYS}"),
        ({"seed": 1, "index": 0, "size": 3}, f"size: got 3 without rng, {KEYS}"),
        ({"seed": 1, "rng": RNG}, f"seed: got a value besides rng, {KEYS}"),
        ({"index": 0, "rng": RNG}, f"index: got a value besides rng, {KEYS}"),
        ({"hit": 0, "rng": RNG}, f"hit: got a value besides rng, {KEYS}"),
        ({"rng": 1}, "rng: got int, allowed: a numpy.random.Generator"),
        ({"rng": RNG, "size": -1}, "size: got -1, allowed: an integer or a tuple"),
        ({"rng": RNG, "size": (2, 1.5)}, "size: got 1.5, allowed: an integer or a tuple"),
        ({"rng": RNG, "size": 10**13}, "size: got 10000000000000, allowed: 2**32 draws at most"),
        ({"rng": RNG, "size": "7"}, "size: got '7', allowed: an integer or a tuple"),
    ],
)
def test_keys_or_a_generator(table, method, given, message):
    state = RNG.bit_generator.state
    arguments = IMPACT if method == "rebound" else {"alpha1": 0.7, "speed": 100.0}
    with pytest.raises(InputError) as refusal:
        getattr(table, method)(**arguments, **given)
    assert str(refusal.value).startswith(message)
    assert RNG.bit_generator.state == state  # nothing was taken from it


@pytest.mark.parametrize(
    ("alpha1", "speed", "index", "hit", "shape"),
    [
        (0.7, 100.0, 4, 0, ()),
        ([0.7], 100.0, 4, 0, (1,)),
        ([0.7, 0.8], 100.0, [4, 5], 0, (2,)),
        (0.7, 100.0, [4, 5, 6], 0, (3,)),
        (0.7, 100.0, 4, [0, 1], (2,)),
        ([[0.7], [0.8]], [[100.0, 120.0, 140.0]], [[4, 5, 6]], 0, (2, 3)),
        (0.7, [[[100.0, 120.0]]], [[[1], [2]]], np.zeros((4, 1, 1), int), (4, 2, 2)),
        ([], 100.0, [], 0, (0,)),
        (np.empty((2, 0)), 100.0, 1, 0, (2, 0)),
    ],
)
def test_shapes_broadcast(table, alpha1, speed, index, hit, shape):
    keys = {"seed": 1, "index": index, "hit": hit}
    states = table.sample(alpha1, speed, **keys)
    assert states.shape == (*shape, 6)
    out = np.empty((*shape, 6), np.float32)
    assert table.sample(alpha1, speed, **keys, out=out) is out
    np.testing.assert_array_equal(out, states.astype(np.float32))
    rows = np.broadcast_arrays(alpha1, speed, index, hit)
    for place in np.ndindex(shape):
        one = [values[place] for values in rows]
        np.testing.assert_array_equal(
            table.sample(*one[:2], seed=1, index=one[2], hit=one[3]), states[place]
        )
    wall = np.multiply.outer(np.ones(np.shape(alpha1)), [0.0, 1.0, 0.0])
    given = [60.0, -80.0, 0.0], wall, np.broadcast_to(1e-5, shape)
    rebound = table.rebound(*given, **keys, grain="fresh")
    assert rebound.velocity.shape == rebound.omega.shape == (*shape, 3)


def test_large_inputs_are_not_copied():
    """Scalars stay one row, arrays of the right type and shape are passed on as they are."""
    angles = np.full((300, 100), 0.7)
    index = np.arange(30_000, dtype=np.uint64).reshape(300, 100)
    _, rows = broadcast({"alpha1": angles, "speed": 100.0}, Keys(seed=1, index=index))
    assert np.shares_memory(rows.arrays["alpha1"], angles)
    assert np.shares_memory(rows.arrays["index"], index)
    assert rows.arrays["speed"].shape == rows.arrays["hit"].shape == (1,)


@pytest.mark.parametrize("dtype", [np.float32, np.int64, np.uint16])
def test_dtypes_and_strides_of_conditions(table, dtype):
    speed = np.arange(60, 80, dtype=dtype)
    expected = table.sample(0.7, np.arange(60.0, 80.0, 2.0), seed=1, index=range(10))
    np.testing.assert_array_equal(table.sample(0.7, speed[::2], seed=1, index=range(10)), expected)


def test_what_a_table_says_of_itself(table, contents):
    assert table.alpha_range == (np.deg2rad(20.0), np.pi / 2)
    assert table.speed_range == (50.0, 300.0)
    assert table.columns == ("u", "v", "w", "omega_x", "omega_y", "omega_z")
    assert table.pair == "made-up"
    assert table.config == contents.config
    assert table.accuracy["ks"].shape == (2, 6)
    assert set(table.accuracy) == {
        *("alpha_deg", "speed", "ks", "sliced_wasserstein", "correlation_error", "auc")
    }
    assert repr(table) == "<sampler.Table made-up: 20 to 90 deg, 50 to 300 m/s>"


def _counts(**found):
    return {"angle": 0, "speed": 0, "spin": 0, "extrapolated": 0} | found


def test_draws_outside_are_counted_by_kind(table):
    alpha1 = np.full(N, 0.7)
    alpha1[::10] = 0.1
    first = table.sample(alpha1, 100.0, seed=1, index=range(N), threads=3)
    assert table.counts == _counts(angle=N // 10)
    table.rebound(**IMPACT | {"velocity": [1.0, -500.0, 0.0]}, seed=1, index=0)
    assert table.counts == _counts(angle=N // 10, speed=1)
    edge = table.sample(table.alpha_range[0], 100.0, seed=1, index=np.arange(0, N, 10))
    np.testing.assert_array_equal(first[::10], edge)
    assert table.counts == _counts(angle=N // 10, speed=1)


class TestWarning:
    """One warning a table and kind, at the first draws of it, with their number."""

    def test_comes_once_a_kind_with_the_count_at_the_line_that_drew(self, table):
        def draw():
            table.sample(0.7, [100.0, 20.0, 310.0], seed=1, index=range(3))
            table.sample(0.7, 20.0, seed=1, index=0)
            table.rebound(**IMPACT | {"velocity": [100.0, -1.0, 0.0]}, seed=1, index=0)

        with pytest.warns(OutsideTableWarning) as told:
            draw()
        assert [str(one.message) for one in told] == [
            "speed: got an impact at 40.107 deg, 20 m/s at row 1 (particle 1), allowed: 20 to 90 "
            "deg, 50 to 300 m/s, the range of the table made-up; 2 of the rows of this call took "
            "its nearest condition; table.counts goes on counting, without further warnings",
            "velocity: got an impact at 0.572939 deg, 100.005 m/s at row 0 (particle 0), allowed: "
            "20 to 90 deg, 50 to 300 m/s, the range of the table made-up; 1 of the rows of this "
            "call took its nearest condition; table.counts goes on counting, without further "
            "warnings",
        ]
        assert told[0].filename == __file__
        assert table.counts == _counts(angle=1, speed=3)

    def test_comes_of_speeds_that_were_not_measured(self, contents):
        table = sampler.Table(replace(contents, valid_speed=(100.0, 200.0)))
        with pytest.warns(
            OutsideTableWarning, match=r"^velocity: got 60 m/s at row 0 \(particle 4"
        ):
            table.rebound(**IMPACT | {"velocity": [0.0, -60.0, 0.0]}, seed=1, index=4)
        assert table.extrapolated == 1

    def test_does_not_come_within_the_table_nor_from_refusals(self, table, table_path):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            table.sample(0.7, [50.0, 300.0], seed=1, index=range(2))
            with pytest.raises(InputError):
                sampler.load(table_path, outside="raise").sample(0.7, 20.0, seed=1, index=0)

    def test_as_an_error_leaves_the_count_right(self, table):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(OutsideTableWarning):
                table.sample(0.7, 20.0, seed=1, index=0)
            table.sample(0.7, 20.0, seed=1, index=0)
        assert table.counts == _counts(speed=2)


def test_counting_is_safe_between_threads(table):
    def draw():
        for _ in range(200):
            table.sample([0.1, 0.7, 0.1], 100.0, seed=1, index=range(3))

    threads = [threading.Thread(target=draw) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert table.counts == _counts(angle=4 * 200 * 2)


@pytest.mark.parametrize("threads", [1, 4])
def test_outside_can_be_refused(table_path, threads):
    table = sampler.load(table_path, outside="raise")
    speed = np.full(1000, 100.0)
    speed[[600, 333, 900]] = 301.0
    refusal = r"speed: got an impact at 40.107 deg, 301 m/s at row 333 \(particle 333\), allowed: "
    with pytest.raises(InputError, match=refusal):
        table.sample(0.7, speed, seed=1, index=range(1000), threads=threads)
    with pytest.raises(InputError, match=r"alpha1: got an impact at 5.7295\d* deg, .* at row 0 "):
        table.sample(0.1, speed, seed=1, index=range(1000), threads=threads)
    velocity = np.tile([80.0, -60.0, 0.0], (1000, 1))
    velocity[700] = [100.0, -1.0, 0.0]
    with pytest.raises(InputError, match=r"velocity: got an impact at 0.5729\d+ deg, .* row 700 "):
        table.rebound(**IMPACT | {"velocity": velocity}, seed=1, index=range(1000), threads=threads)
    assert table.counts == _counts()
    # Of an outside row and a bad one, whichever comes first.
    speed[100] = np.nan
    with pytest.raises(InputError, match="speed: got nan at row 100"):
        table.sample(0.7, speed, seed=1, index=range(1000), threads=threads)
    speed[50] = 10.0
    with pytest.raises(InputError, match=r"speed: got an impact at .*, 10 m/s at row 50 "):
        table.sample(0.7, speed, seed=1, index=range(1000), threads=threads)


@pytest.mark.parametrize("threads", [1, 4])
@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("alpha1", np.nan, "finite numbers"),
        ("alpha1", np.inf, "finite numbers"),
        ("alpha1", 0.0, "above 0, at most pi/2 rad"),
        ("alpha1", -0.2, "above 0, at most pi/2 rad"),
        ("alpha1", 1.5709, "above 0, at most pi/2 rad"),
        ("speed", np.nan, "finite numbers"),
        ("speed", 0.0, "above 0 m/s"),
        ("speed", -20.0, "above 0 m/s"),
    ],
)
def test_first_bad_condition_is_named(table, threads, name, value, allowed):
    inputs = dict(zip(("alpha1", "speed"), _conditions(1000), strict=True))
    inputs[name][[871, 423, 999]] = value
    with pytest.raises(InputError) as refusal:
        table.sample(**inputs, seed=1, index=range(1000), threads=threads)
    said = f"{name}: got {value:.9g} at row 423 (particle 423), allowed: {allowed}"
    assert str(refusal.value) == said
    assert table.counts == _counts()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity": [np.nan, 0, 0]}, "velocity: got nan, 0, 0 at row 2, allowed: finite"),
        ({"velocity": [0, 0, 0]}, "velocity: got 0, 0, 0 at row 2, allowed: 1e-150 m/s or more"),
        ({"velocity": [0, -1e-170, 0]}, "got 0, -1e-170, 0 at row 2, allowed: 1e-150 m/s or"),
        ({"velocity": [1, 0, 0]}, "velocity: got 1, 0, 0 at row 2, allowed: towards the wall"),
        ({"velocity": [1, 2, 0]}, "velocity: got 1, 2, 0 at row 2, allowed: towards the wall"),
        (
            {"velocity": [1e200, -1e200, 0]},
            "row 2, allowed: speeds and spins times a/V below 1e150",
        ),
        ({"normal": [0, 0, 0]}, "normal: got 0, 0, 0 at row 2, allowed: any length but zero"),
        ({"normal": [0, np.inf, 0]}, "normal: got 0, inf, 0 at row 2, allowed: finite"),
        ({"half_size": 0.0}, "half_size: got 0 at row 2, allowed: 1e-09 to 0.1 m"),
        ({"half_size": 1e-310}, "half_size: got 1e-310 at row 2, allowed: 1e-09 to 0.1 m"),
        ({"half_size": 20.0}, "half_size: got 20 at row 2, allowed: 1e-09 to 0.1 m"),
        ({"half_size": np.nan}, "half_size: got nan at row 2, allowed: finite"),
        ({"wall_velocity": [0, -99, 0]}, "row 2, allowed: towards the wall"),
        ({"wall_velocity": [0, np.nan, 0]}, "wall_velocity: got 0, nan, 0 at row 2"),
    ],
)
def test_first_bad_impact_is_named(table, change, message):
    inputs = {
        "velocity": np.tile([60.0, -80.0, 0.0], (5, 1)),
        "normal": np.tile([0.0, 1.0, 0.0], (5, 1)),
        "half_size": np.full(5, 1e-5),
        "wall_velocity": np.zeros((5, 3)),
    }
    for name, value in change.items():
        inputs[name][[2, 4]] = value
    with pytest.raises(InputError) as refusal:
        table.rebound(**inputs, grain="fresh", seed=1, index=range(5))
    assert message in str(refusal.value).replace(" (particle 2)", "")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seed": -1}, "seed: got -1, allowed: an integer from 0 to 2**64 - 1"),
        ({"seed": 2**64}, "seed: got 18446744073709551616, allowed"),
        ({"index": [3, -2]}, "index: got -2 at index 1, allowed: integers from 0 to 2**64 - 1"),
        ({"index": [[1, 2], [3, -4]]}, "index: got -4 at index (1, 1), allowed: integers"),
        ({"hit": [0, -1]}, "hit: got -1 at index 1"),
        ({"alpha1": "0.5"}, "alpha1: got str96 values, allowed: real numbers"),
        ({"alpha1": 0.5j}, "alpha1: got complex128 values, allowed: real numbers"),
        ({"alpha1": True}, "alpha1: got bool values, allowed: real numbers"),
        ({"speed": [[1.0], [1.0, 2.0]]}, "speed: got rows of unequal length"),
        (
            {"speed": [100.0] * 3, "index": [1, 2]},
            "index: got shape (2,), allowed: one that broadcasts with (3,)",
        ),
        ({"speed": [100.0] * 3, "alpha1": []}, "speed: got shape (3,), allowed: one that broad"),
        ({"speed": [[100.0], [0.0]], "index": [[8], [9]]}, "got 0 at row (1, 0) (particle 9)"),
        ({"threads": 0}, "threads: got 0, allowed: an integer from 1 to 4096"),
        ({"threads": 1.5}, "threads: got 1.5, allowed"),
    ],
)
def test_wrong_arguments(table, change, message):
    with pytest.raises(InputError) as refusal:
        table.sample(**({"alpha1": 0.7, "speed": 100.0, "seed": 1, "index": 0} | change))
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocity": [1.0, -1.0]}, "velocity: got shape (2,), allowed: (3,) or (..., 3)"),
        ({"normal": 1.0}, "normal: got shape (), allowed: (3,) or (..., 3)"),
        ({"normal": [[[0, 1, 0], [0, -1, 0]]], "index": [[0, 1]]}, "got 60, -80, 0 at row (0, 1)"),
        ({"half_size": [1e-5, 1e-5], "velocity": -np.ones((3, 3))}, "half_size: got shape (2,)"),
        *(
            ({name: column, "velocity": -np.ones((3, 3))}, f"{name}: got rows of shape (3, 1)")
            for name, column in (
                *((name, np.full((3, 1), 1e-5)) for name in ("half_size", "roughness")),
                *((name, np.zeros((3, 1), int)) for name in ("index", "hit")),
            )
        ),
    ],
)
def test_wrong_vectors(table, change, message):
    with pytest.raises(InputError) as refusal:
        table.rebound(**({"seed": 1, "index": 0} | IMPACT | change))
    assert message in str(refusal.value)


def test_outside_must_be_known(table_path):
    for make in (
        lambda: sampler.load(table_path, outside="ignore"),
        lambda: sampler.Table(make_contents(), outside="ignore"),
    ):
        with pytest.raises(InputError, match="outside: got 'ignore', allowed: 'clamp', 'raise'"):
            make()
