"""The Table class: keys, shapes, threads, ranges, and what it refuses."""

import threading
import warnings
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from synthetic_table import make_contents

import sampler
from sampler import InputError, OutsideTableWarning
from sampler.arguments import Keys, broadcast

pytestmark = pytest.mark.processor

N = 50_000
RNG = np.random.default_rng(1)
IMPACT = {"velocity": [60.0, -80.0, 0.0], "normal": [0.0, 1.0, 0.0], "half_size": 1e-5}
IMPACT["grain"] = "fresh"
THREE = {"velocity": -np.ones((3, 3))}


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


@pytest.mark.parametrize("method", ["sample", "rebound"])
def test_generators_in_place_of_keys(table, method):
    """For people who want random numbers and not keys: calls differ, equal generators do not."""
    given = IMPACT if method == "rebound" else {"alpha1": 0.7, "speed": 100.0}
    draw, (one, two, three) = getattr(table, method), map(np.random.default_rng, (1, 1, 1))
    first, second = ([draw(**given, size=(4, 5), rng=r) for _ in range(2)] for r in (one, two))
    if method == "rebound":
        first, second = (tuple(np.dstack(r) for r in rebounds) for rebounds in (first, second))
    np.testing.assert_array_equal(first, second)
    assert (np.array(first[0]) != first[1]).any(axis=-1).all()
    keys = {"seed": three.integers(2**64, dtype=np.uint64), "index": np.arange(20).reshape(4, 5)}
    expected = draw(**given, **keys, hit=0)
    expected = np.dstack(expected) if method == "rebound" else expected
    np.testing.assert_array_equal(first[0], expected)


@pytest.mark.parametrize("method", ["sample", "rebound"])
@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("seed", {}),
        ("index", {"seed": 1}),
        ("index", {"seed": 1, "hit": 0}),
        ("size", {"seed": 1, "index": 0, "size": 3}),
        *((name, {name: 1, "rng": RNG}) for name in ("seed", "index", "hit")),
        ("rng", {"rng": 1}),
        *(("size", {"rng": RNG, "size": size}) for size in (-1, (2, 1.5), 10**13, "7")),
    ],
)
def test_keys_or_a_generator(table, method, field, given):
    state = RNG.bit_generator.state
    arguments = IMPACT if method == "rebound" else {"alpha1": 0.7, "speed": 100.0}
    refused(field, getattr(table, method), **arguments, **given)
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
    for dtype in (np.float64, np.float32):
        out = np.empty((*shape, 6), dtype)
        assert table.sample(alpha1, speed, **keys, out=out) is out
        np.testing.assert_array_equal(out, states.astype(dtype))
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
    assert rebound.inertia.shape == shape


def test_an_output_may_be_memory_that_is_read(table):
    alpha1, speed = _conditions()
    expected = table.sample(alpha1, speed, seed=1, index=range(N))
    room = np.zeros((N, 6))
    room.reshape(-1)[:N] = alpha1
    table.sample(room.reshape(-1)[:N], speed, seed=1, index=range(N), out=room)
    np.testing.assert_array_equal(room, expected)
    room.view(np.uint64).reshape(-1)[:N] = np.arange(N)
    table.sample(alpha1, speed, seed=1, index=room.view(np.uint64).reshape(-1)[:N], out=room)
    np.testing.assert_array_equal(room, expected)


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
    assert table.columns == ("u", "v", "w", "omega_x", "omega_y", "omega_z")
    assert table.pair == "made-up"
    assert table.config == contents.config
    assert table.accuracy["ks"].shape == (2, 6)
    assert set(table.accuracy) == {
        "alpha_deg",
        "speed",
        "ks",
        "sliced_wasserstein",
        "correlation_error",
        "auc",
    }
    assert repr(table) == "<sampler.Table made-up: 20 to 90 deg, 50 to 300 m/s>"


def _counts(**changes):
    return {"angle": 0, "speed": 0, "spin": 0, "extrapolated": 0} | changes


def test_draws_outside_are_counted_by_kind(table):
    alpha1 = np.full(N, 0.7)
    alpha1[::10] = 0.1
    first = table.sample(alpha1, 100.0, seed=1, index=range(N), threads=3)
    assert table.counts == _counts(angle=N // 10)
    table.rebound(**IMPACT | {"velocity": [1.0, -500.0, 0.0]}, seed=1, index=0)
    assert table.counts == _counts(angle=N // 10, speed=1)
    edge = table.sample(
        np.radians(table.alpha_nodes_deg[0]), 100.0, seed=1, index=np.arange(0, N, 10)
    )
    np.testing.assert_array_equal(first[::10], edge)
    assert table.counts == _counts(angle=N // 10, speed=1)


class TestWarning:
    """One warning a table and kind, at the first draws of it, with their number."""

    def test_comes_once_a_kind_with_the_count_at_the_line_that_drew(self, table):
        def draw():
            table.sample(0.7, [100.0, 20.0, 310.0], seed=1, index=range(3))
            table.sample(0.7, 20.0, seed=1, index=0)
            table.rebound(**IMPACT | {"velocity": [100.0, -1.0, 0.0]}, seed=1, index=0)

        with pytest.warns(OutsideTableWarning) as warned:
            draw()
        assert [str(one.message).partition(":")[0] for one in warned] == ["speed", "velocity"]
        assert warned[0].filename == __file__
        assert table.counts == _counts(angle=1, speed=3)

    def test_comes_of_speeds_that_were_not_measured(self, contents):
        table = sampler.Table(replace(contents, valid_speed=(100.0, 200.0)))
        with pytest.warns(
            OutsideTableWarning, match="^velocity: got 60 m/s.*measured at 100 to 200 m/s"
        ):
            table.rebound(**IMPACT | {"velocity": [0.0, -60.0, 0.0]}, seed=1, index=4)
        assert table.counts["extrapolated"] == 1

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


#: Changes of rows of draws by their name, and whether the table clamps.
BAD_CONDITIONS = [
    *(("alpha1", value, "clamp") for value in (np.nan, np.inf, 0.0, -0.2, 1.5709)),
    *(("speed", value, "clamp") for value in (np.nan, np.inf, 0.0, -20.0)),
    ("alpha1", 0.01, "raise"),
    *(("speed", value, "raise") for value in (301.0, 1e4, np.nan)),
]


@pytest.mark.parametrize(("count", "threads"), [(1000, 1), (1001, 4), (N, 2)])
@pytest.mark.parametrize(("name", "value", "outside"), BAD_CONDITIONS)
def test_first_bad_condition_is_named(table_path, name, value, outside, count, threads):
    """And the array for the states is left as it was."""
    table = sampler.load(table_path, outside=outside)
    inputs = dict(zip(("alpha1", "speed"), _conditions(count), strict=True))
    inputs[name][[871, 423, 999]] = value
    given, out = {"seed": 1, "index": range(count), "threads": threads}, np.full((count, 6), 7.0)
    line = refused(name, table.sample, **inputs, **given, out=out)
    assert " at row 423 (particle 423)" in line
    # Of an outside row and a bad one, whichever comes first.
    for row, first in ((100, np.nan), (50, 10.0 if outside == "raise" else 0.0)):
        inputs["speed"][row] = first
        assert f" at row {row} " in refused("speed", table.sample, **inputs, **given, out=out)
    assert (out == 7.0).all()
    assert table.counts == _counts()


@pytest.mark.parametrize("threads", [1, 4])
@pytest.mark.parametrize(
    ("name", "values", "allowed"),
    [
        ("velocity", ([np.nan, 0, 0],), "finite"),
        ("velocity", ([0, 0, 0], [0, -1e-170, 0]), "1e-150"),
        ("velocity", ([1, 0, 0], [1, 2, 0]), "towards"),
        ("velocity", ([1e200, -1e200, 0],), "below 1e150"),
        ("velocity", ([100.0, -1.0, 0.0],), "20 to 90 deg"),
        ("normal", ([0, np.inf, 0],), "finite"),
        ("normal", ([0, 0, 0],), "any length but zero"),
        ("half_size", (0.0, 1e-310, 200.0), "1e-09 to 100 m"),
        ("half_size", (np.nan,), "finite"),
        ("wall_velocity", ([0, np.nan, 0],), "finite"),
    ],
)
def test_first_bad_impact_is_named(table_path, name, values, allowed, threads):
    table = sampler.load(table_path, outside="raise")
    for value in values:
        inputs = {"velocity": np.tile([60.0, -80.0, 0.0], (1000, 1))}
        inputs |= {"half_size": np.full(1000, 1e-5), "wall_velocity": np.zeros((1000, 3))}
        inputs["normal"] = np.tile([0.0, 1.0, 0.0], (1000, 1))
        inputs[name][[700, 400]] = value
        given = {"grain": "fresh", "seed": 1, "index": range(1000), "threads": threads}
        line = refused(name, table.rebound, **inputs, **given)
        assert " at row 400 (particle 400), allowed: " in line
        assert allowed in line.partition("allowed: ")[2]
    assert table.counts == _counts()


@pytest.mark.parametrize(
    ("field", "change"),
    [
        *(("alpha1", {"alpha1": value}) for value in ("0.5", 0.5j, True)),
        ("speed", {"speed": [[1.0], [1.0, 2.0]]}),
        ("speed", {"speed": [[100.0], [0.0]], "index": [[8], [9]], "out": None}),
        ("index", {"speed": [100.0] * 3, "index": [1, 2]}),
        ("speed", {"speed": [100.0] * 3, "alpha1": []}),
        *(("threads", {"threads": value}) for value in (0, 1.5)),
        *(("out", {"out": out}) for out in (np.ma.zeros(6), np.zeros(6, int), np.zeros((2, 6)))),
    ],
)
def test_wrong_arguments(table, field, change):
    given = {"alpha1": 0.7, "speed": 100.0, "seed": 1, "index": 0, "out": np.full(6, 7.0)} | change
    refused(field, table.sample, **given)
    assert "out" in change or (given["out"] == 7.0).all()


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("velocity", {"velocity": [1.0, -1.0]}),
        ("normal", {"normal": 1.0}),
        ("velocity", {"normal": [[[0, 1, 0], [0, -1, 0]]], "index": [[0, 1]]}),
        ("half_size", {"half_size": [1e-5, 1e-5], **THREE}),
        *((x, {x: np.zeros((3, 1)), **THREE}) for x in ("half_size", "roughness")),
        *((x, {x: np.zeros((3, 1), int), **THREE}) for x in ("index", "hit")),
    ],
)
def test_wrong_vectors(table, field, change):
    refused(field, table.rebound, **({"seed": 1, "index": 0} | IMPACT | change))


def test_outside_must_be_known(table_path):
    refused("outside", sampler.load, table_path, outside="ignore")
    refused("outside", sampler.Table, make_contents(), outside="ignore")
