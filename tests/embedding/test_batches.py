"""Batches in C: the results of calls one by one, up to the first error; and grains."""

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS

SEED = 5
#: Arrays of each law, and whether grains are fresh: without spin, of rebounds the own grain or the
#: law of first impacts; with it and the keys' grain, a fresh one or a given one; of a given grain
#: that does not spin.
LAWS = {
    "nodes": ((), 0),
    "first": ((), 1),
    "own": (("spin",), 0),
    "fresh": (("spin",), 1),
    "given": (("spin", "grain"), 0),
    "unspun": (("grain",), 0),
}


def record(kind, arrays, fresh=0, **flags):
    """Make a record of conditions or impacts."""
    found = kind(**{name: array.ctypes.data for name, array in arrays.items()}, **flags)
    found.fresh_grains = fresh
    return found


def keys_and_grains(n, rng):
    grain = np.column_stack([rng.choice([0.0, 4.0], n), *rng.uniform(0.5, 1.0, (2, n))])
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    return {"grain": grain, "index": index, "hit": rng.integers(0, 2**32, n, dtype=np.uint32)}


def conditions(n, law):
    """Make angles and speeds beyond both ends of the laws, spins of all sizes, grains and keys."""
    rng = np.random.default_rng(3)
    arrays = {"alpha1": rng.uniform(0.005, 0.5 * np.pi, n), "speed": np.exp(rng.uniform(1, 7, n))}
    arrays["spin"] = rng.standard_normal((n, 3)) * np.exp(rng.normal(0.0, 1.5, (n, 1)))
    arrays["spin"][::5] = 0.0
    return kept(arrays | keys_and_grains(n, rng), law, "spin")


def impacts(n, law, wall=True, rough=False):
    """Make impacts at walls of all directions: some grazing, some normal, some at smooth places."""
    rng = np.random.default_rng(1)
    normal, wall_velocity = rng.standard_normal((2, n, 3))
    e_y = normal / np.linalg.norm(normal, axis=1)[:, None]
    velocity = 100.0 * rng.standard_normal((n, 3))
    velocity -= 2.0 * np.maximum((velocity * e_y).sum(axis=1), 0.0)[:, None] * e_y
    velocity[: n // 10] -= 0.99 * ((velocity * e_y).sum(axis=1)[:, None] * e_y)[: n // 10]
    velocity[n // 10 : n // 8] = -100.0 * e_y[n // 10 : n // 8]
    half_size = rng.uniform(1e-6, 1e-3, n)
    arrays = {"velocity": velocity + wall * wall_velocity, "normal": normal, "half_size": half_size}
    arrays["omega"] = 100.0 * rng.standard_normal((n, 3)) / half_size[:, None]
    arrays |= {"wall_velocity": wall_velocity} if wall else {}
    arrays |= {"roughness": rng.uniform(0.0, 0.5, n) * (np.arange(n) % 7 > 0)} if rough else {}
    return kept(arrays | keys_and_grains(n, rng), law, "omega")


def kept(arrays, law, spin):
    """Leave out the spin and the grain where a law has none."""
    names = [spin if name == "spin" else name for name in LAWS[law][0]]
    return {k: v for k, v in arrays.items() if k not in (spin, "grain") or k in names}


def one_grain(library, table, arrays, law, k):
    """Grain of a row, for calls one by one, or None for that of the keys."""
    if law != "fresh":
        return arrays["grain"][k] if "grain" in arrays else None
    grain = np.zeros(3)
    key = SEED, int(arrays["index"][k]), int(arrays["hit"][k])
    assert library.rbt_fresh_grain(table, *key, grain) == 0
    return grain


def one_draw(library, table, arrays, law, k):
    """Code and all ten variables."""
    values = np.zeros(10)
    alpha1, speed = arrays["alpha1"][k], arrays["speed"][k]
    key, spin, grain = (SEED, int(arrays["index"][k]), int(arrays["hit"][k])), None, None
    if law not in ("nodes", "first"):
        spin = arrays["spin"][k] if "spin" in arrays else None
        grain = one_grain(library, table, arrays, law, k)
    return library.rbt_draw_all(table, alpha1, speed, spin, grain, *key, values), values


def one_rebound(library, table, arrays, law, k, isotropic=0):
    """Code, and velocity and angular velocity."""
    after, key = np.full((2, 3), 7.0), (SEED, int(arrays["index"][k]), int(arrays["hit"][k]))
    wall, omega = (arrays[n][k] if n in arrays else None for n in ("wall_velocity", "omega"))
    motion = arrays["velocity"][k], arrays["normal"][k], arrays["half_size"][k], wall
    roughness = arrays["roughness"][k] if "roughness" in arrays else 0.0
    grain = one_grain(library, table, arrays, law, k)
    library.rbt_keep_grains(table, law != "first")
    walls = roughness, isotropic
    code = library.rbt_rebound_grain(table, *motion, *walls, omega, grain, *key, *after)
    library.rbt_keep_grains(table, 1)
    return code, after


def check_report(report, codes, code):
    """Check code and report of a batch without an error."""
    n, flags = len(codes), np.array(codes, dtype=int)
    assert (report.row, code) == (n, np.bitwise_or.reduce(flags))
    for flag, row, count in (
        (1, report.clamped_row, report.clamped),
        (2, report.extrapolated_row, report.extrapolated),
    ):
        flagged = np.flatnonzero(flags & flag)
        assert (row, count) == (flagged[0] if flagged.size else n, flagged.size)


@pytest.mark.parametrize("n", [0, 1, 31, 33, 200])
@pytest.mark.parametrize(
    ("name", "law"),
    [("full", "nodes"), ("works", "nodes"), ("pruned", "nodes"), *(("spin", law) for law in LAWS)],
)
def test_draws_are_those_one_by_one(library, name, law, n):
    arrays, report, columns = conditions(n, law), toolchain.Report(), np.zeros(10, np.int32)
    given, ends = record(toolchain.Conditions, arrays, LAWS[law][1]), np.zeros(2)
    with toolchain.opened(library, VECTORS / f"{name}.rbt") as table:
        one_by_one = [one_draw(library, table, arrays, law, k) for k in range(n)]
        codes, values = [code for code, _ in one_by_one], np.array([v for _, v in one_by_one])
        held = columns[: library.rbt_components(table, columns)]
        expected = values.reshape(n, 10)[:, held]
        states, singles = np.full((n, len(held)), 7.0), np.full((n, len(held)), 7.0, np.float32)
        code = library.rbt_sample_batch(table, n, given, SEED, states, None, report)
        assert library.rbt_sample_batch(table, n, given, SEED, None, singles, None) == code
        np.testing.assert_array_equal(states, expected)
        np.testing.assert_array_equal(singles, expected.astype(np.float32))
        check_report(report, codes, code)
        library.rbt_valid_speed(table, ends)
        beyond = (arrays["speed"] < ends[0]) | (arrays["speed"] > ends[1])
        assert report.extrapolated == beyond.sum()
        if law in ("nodes", "own", "fresh"):
            library.rbt_keep_grains(table, law != "fresh")
            six, spin = np.zeros((n, 6)), arrays.get("spin")
            rows = arrays["alpha1"], arrays["speed"], spin, SEED, arrays["index"], arrays["hit"]
            assert library.rbt_draw_batch(table, n, *rows, six, None) == code
            np.testing.assert_array_equal(six, values.reshape(n, 10)[:, :6])


@pytest.mark.parametrize("n", [0, 1, 31, 33, 200])
@pytest.mark.parametrize(("wall", "rough", "flat"), [(1, 0, 1), (0, 1, 1), (0, 1, 0)])
@pytest.mark.parametrize("law", LAWS)
def test_rebounds_are_those_one_by_one(library, law, wall, rough, flat, n):
    arrays, report = impacts(n, law, wall, rough), toolchain.Report()
    given = record(toolchain.Impacts, arrays, LAWS[law][1], isotropic=1 - flat)
    after = np.full((2, n, 3), 7.0)
    with toolchain.opened(library, VECTORS / "spin.rbt") as table:
        one_by_one = [one_rebound(library, table, arrays, law, k, 1 - flat) for k in range(n)]
        code = library.rbt_rebound_batch(table, n, given, SEED, *after, report)
        codes, expected = [c for c, _ in one_by_one], np.array([a for _, a in one_by_one])
        expected = expected.reshape(n, 2, 3).transpose(1, 0, 2)
        np.testing.assert_array_equal(after, expected)
        check_report(report, codes, code)
        # results may take the place of arguments
        places = arrays["velocity"], arrays.get("omega", after[1])
        assert library.rbt_rebound_batch(table, n, given, SEED, *places, None) == code
        np.testing.assert_array_equal(places, expected)


@pytest.mark.parametrize(("name", "spins"), [("works", 0), ("spin-works", 0), ("spin-works", 1)])
def test_works_are_those_of_the_draw(library, name, spins):
    """In a frame of the impact that is the lab's."""
    motion, half_size, works = conditions(40, "own"), 2e-5, np.zeros(2)
    with toolchain.opened(library, VECTORS / f"{name}.rbt") as table:
        for k, (alpha1, speed) in enumerate(zip(motion["alpha1"], motion["speed"], strict=True)):
            key = SEED, int(motion["index"][k]), int(motion["hit"][k])
            spin = spins * motion["spin"][k] if name == "spin-works" else None
            omega = spin * speed / half_size if spins else None
            velocity = speed * np.array([np.cos(alpha1), -np.sin(alpha1), 0.0])
            impact = velocity, np.array([0.0, 3.0, 0.0]), half_size, None
            code, values = library.rbt_works(table, *impact, omega, *key, works), np.zeros(10)
            assert library.rbt_draw_all(table, alpha1, speed, spin, None, *key, values) == code >= 0
            np.testing.assert_allclose(works, 0.5 * speed**2 * values[8:], rtol=1e-4)
            assert k > 0 or works.min() > 0.0
        assert library.rbt_works(table, -velocity, *impact[1:], omega, *key, works) == -2


@pytest.mark.parametrize("bad", [0, 31, 33])
@pytest.mark.parametrize(
    ("law", "name", "value", "code"),
    [
        ("nodes", "alpha1", np.nan, -1), ("nodes", "alpha1", -1.0, -2), ("nodes", "speed", 0.0, -3),
        ("own", "spin", np.inf, -1), ("own", "spin", 1e200, -1), ("own", "speed", 0.0, -3),
        ("given", "grain", 99.0, -32), ("nodes", "velocity", np.nan, -1),
        ("nodes", "wall_velocity", None, -2), ("nodes", "normal", 0.0, -4),
        ("own", "half_size", 1e-310, -5), ("own", "roughness", np.nan, -8),
        ("own", "roughness", -1e-300, -8), ("nodes", "roughness", 0.5000001, -8),
        ("own", "omega", np.inf, -1), ("unspun", "grain", 0.3, -32),
    ],
)  # fmt: skip
def test_a_batch_stops_before_the_first_error(library, bad, law, name, value, code):
    n, report = 70, toolchain.Report()
    draws = name in ("alpha1", "speed", "spin") or law == "given"
    rough = name in ("roughness", "grain")
    arrays = conditions(n, law) if draws else impacts(n, law, rough=rough)
    kind = toolchain.Conditions if draws else toolchain.Impacts
    whole, found = np.full((2, 2, n, 3), 7.0)
    with toolchain.opened(library, VECTORS / "spin.rbt") as table:

        def run(results):
            given = record(kind, arrays)
            if draws:  # a state of this table has three columns
                where = results[0], None
                return library.rbt_sample_batch(table, n, given, SEED, *where, report)
            return library.rbt_rebound_batch(table, n, given, SEED, *results, report)

        assert run(whole) >= 0
        for row in (bad, 60):  # only the first is reported
            # a wall that flees from the particle
            arrays[name][row] = -1e4 * arrays["normal"][row] if value is None else value
        assert (run(found), report.row) == (code, bad)
        one = one_draw if draws else one_rebound
        alone, values = one(library, table, arrays, law, bad)
    assert alone == code
    assert np.isin(values, (0.0, 7.0)).all()
    np.testing.assert_array_equal(found[:, :bad], whole[:, :bad])
    assert (found[:, bad:] == 7.0).all()


def test_grains(library):
    """Kept unless told otherwise; that of a batch is the one that a particle keeps."""
    n, (many, own, kept_, fresh, unkept) = 300, np.zeros((5, 300, 3))
    index = np.arange(n, dtype=np.uint64)
    with toolchain.opened(library, VECTORS / "spin.rbt") as table:
        assert library.rbt_grains_batch(table, n, SEED, index, many) == 0
        for k in range(n):
            assert library.rbt_grain(table, SEED, k, 0, own[k]) == 0
            assert library.rbt_grain(table, SEED, k, 3, kept_[k]) == 0
            assert library.rbt_fresh_grain(table, SEED, k, 3, fresh[k]) == 0
        library.rbt_keep_grains(table, 0)
        for k in range(n):
            assert library.rbt_grain(table, SEED, k, 3, unkept[k]) == 0
    np.testing.assert_array_equal(many, own)
    np.testing.assert_array_equal(kept_, own)
    np.testing.assert_array_equal(unkept, fresh)
    assert (fresh[:, 1] != own[:, 1]).any()
    assert set(own[:, 0]) == {0.0, 4.0}


def test_a_table_without_a_spin_law_refuses_spins_and_grains(library):
    arrays, report = conditions(40, "given"), toolchain.Report()
    state, grain, six = np.full(6, 7.0), np.full(3, 7.0), np.full((40, 6), 7.0)
    with toolchain.opened(library, VECTORS / "full.rbt") as table:
        given = record(toolchain.Conditions, arrays)
        assert library.rbt_sample_batch(table, 40, given, SEED, six, None, report) == -9
        assert library.rbt_draw(table, 0.5, 100.0, np.zeros(3), 1, 2, 3, state) == -9
        assert library.rbt_draw(table, 0.5, 0.0, np.zeros(3), 1, 2, 3, state) == -3
        for call in (library.rbt_grain, library.rbt_fresh_grain):
            assert call(table, 1, 2, 3, grain) == -9
        assert library.rbt_grains_batch(table, 1, 1, arrays["index"], grain) == -9
        assert library.rbt_sample_batch(table, 0, given, SEED, six, None, None) == 0
    assert report.row == 0
    assert (np.concatenate([state, grain, six.ravel()]) == 7.0).all()
