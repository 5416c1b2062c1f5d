"""Many rows in one call of C give the same results as one by one; and grains."""

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS

SEED = 5
#: Arrays of each law, and whether grains are fresh: without spin, of rebounds the own grain or the
#: law of first impacts; with it and the keys' grain, a fresh one with inertias that are not known,
#: or a given one; of a given grain that does not spin.
LAWS = {
    "nodes": ((), 0),
    "first": ((), 1),
    "own": (("spin", "inertia"), 0),
    "fresh": (("spin",), 1),
    "given": (("spin", "inertia", "grain"), 0),
    "unspun": (("grain",), 0),
}


def record(kind, arrays, rows=slice(None), **flags):
    """Make a record of conditions, impacts or rebounds; arrays are not copied."""
    return kind(**{name: array[rows].ctypes.data for name, array in arrays.items()}, **flags)


def keys_and_grains(n, rng):
    grain = np.column_stack([rng.choice([0.0, 4.0], n), *rng.uniform(0.5, 1.0, (2, n))])
    index = rng.integers(0, 2**64, n, dtype=np.uint64)
    return {"grain": grain, "index": index, "hit": rng.integers(0, 2**32, n, dtype=np.uint32)}


def inertias(n, rng):
    """Make inertias about the spin: within the moments of most grains, beyond, and not known."""
    return rng.uniform(0.1, 0.45, n) * (np.arange(n) % 3 > 0)


def conditions(n, law):
    """Make angles and speeds beyond both ends of the laws, spins of all sizes, grains and keys."""
    rng = np.random.default_rng(3)
    arrays = {"alpha1": rng.uniform(0.005, 0.5 * np.pi, n), "speed": np.exp(rng.uniform(1, 7, n))}
    arrays["spin"] = rng.standard_normal((n, 3)) * np.exp(rng.normal(0.0, 1.5, (n, 1)))
    arrays["spin"][::5] = 0.0
    arrays["inertia"] = inertias(n, rng)
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
    arrays["inertia"] = inertias(n, rng)
    arrays |= {"wall_velocity": wall_velocity} if wall else {}
    arrays |= {"roughness": rng.uniform(0.0, 0.5, n) * (np.arange(n) % 7 > 0)} if rough else {}
    return kept(arrays | keys_and_grains(n, rng), law, "omega")


def kept(arrays, law, spin):
    """Leave out the spin and the grain where a law has none."""
    names = [spin if name == "spin" else name for name in LAWS[law][0]]
    return {k: v for k, v in arrays.items() if k not in (spin, "inertia", "grain") or k in names}


def sample(library, table, arrays, law, rows=slice(None)):
    """Return the value of the call, the codes and the states."""
    n, fresh = arrays["alpha1"][rows].size, LAWS[law][1]
    states, after = np.full((n, library.rbt_variables(table, None)), 7.0), np.full(n, 7.0)
    codes, only = np.full((2, n), 7, np.int32)
    given = record(toolchain.Conditions, arrays, rows, fresh=fresh)
    assert library.rbt_sample(table, n, given, SEED, None, only) == library.rbt_sample(
        table, n, given, SEED, states, codes
    )
    np.testing.assert_array_equal(only, codes)
    alone, given.inertia_after = states.copy(), after.ctypes.data
    code = library.rbt_sample(table, n, given, SEED, states, None)
    np.testing.assert_array_equal(states, alone)
    return code, codes, np.column_stack([states, after])


def rebound(library, table, arrays, law, rows=slice(None), isotropic=0):
    """Codes, velocities, angular velocities, inertias and works, and what the call returns."""
    n, fresh = arrays["half_size"][rows].size, LAWS[law][1]
    after = {"velocity": np.full((n, 3), 7.0), "omega": np.full((n, 3), 7.0)}
    after |= {"inertia": np.full((n, 1), 7.0)}
    columns = np.zeros(10, np.int32)
    library.rbt_variables(table, columns)
    after |= {"works": np.full((n, 2), 7.0)} if 9 in columns else {}
    after |= {"codes": np.full(n, 7, np.int32)}
    given = record(toolchain.Impacts, arrays, rows, fresh=fresh, isotropic=isotropic)
    report = record(toolchain.Rebounds, after)
    code = library.rbt_rebound(table, n, given, SEED, report)
    codes = after.pop("codes")
    bad = np.flatnonzero(codes < 0)
    assert (report.bad, report.first_bad) == (bad.size, bad[0] if bad.size else n)
    flagged = [(codes[codes > 0] & flag > 0).sum() for flag in 1 << np.arange(8)]
    assert list(report.flagged) == flagged
    return code, codes, np.hstack([*after.values()])


def check_rows(call, library, table, arrays, law, n, **options):
    code, codes, results = call(library, table, arrays, law, **options)
    alone = [call(library, table, arrays, law, slice(k, k + 1), **options) for k in range(n)]
    np.testing.assert_array_equal(codes, [one[0] for one in alone])
    assert (results == np.array([one[2][0] for one in alone]).reshape(results.shape)).all()
    assert code == np.bitwise_or.reduce(codes.astype(int), initial=0)


@pytest.mark.parametrize("n", [0, 1, 15, 31, 33, 200])
@pytest.mark.parametrize(
    ("name", "law"),
    [("full", "nodes"), ("works", "nodes"), ("pruned", "nodes"), *(("spin", law) for law in LAWS)],
)
def test_draws_are_those_one_by_one(library, name, law, n):
    with toolchain.opened(library, VECTORS / f"{name}.rbt") as table:
        check_rows(sample, library, table, conditions(n, law), law, n)


@pytest.mark.parametrize("n", [0, 1, 15, 31, 33, 200])
@pytest.mark.parametrize(("wall", "rough", "flat"), [(1, 0, 1), (0, 1, 1), (0, 1, 0)])
@pytest.mark.parametrize("law", LAWS)
def test_rebounds_are_those_one_by_one(library, law, wall, rough, flat, n):
    arrays, options = impacts(n, law, wall, rough), {"isotropic": 1 - flat}
    with toolchain.opened(library, VECTORS / "spin-works.rbt") as table:
        arrays |= {"grain": np.tile([0.0, 0.8, 0.7], (n, 1))} if "grain" in arrays else {}
        check_rows(rebound, library, table, arrays, law, n, **options)
        expected = rebound(library, table, arrays, law, **options)[2]
        # results may take the place of arguments
        after = {"velocity": arrays["velocity"], "omega": arrays.get("omega", np.zeros((n, 3)))}
        after["inertia"] = arrays.get("inertia", np.zeros(n)).reshape(n, 1)
        given = record(toolchain.Impacts, arrays, fresh=LAWS[law][1], isotropic=1 - flat)
        library.rbt_rebound(table, n, given, SEED, record(toolchain.Rebounds, after))
        np.testing.assert_array_equal(np.hstack([*after.values()]), expected[:, :7])


@pytest.mark.parametrize("bad", [0, 31, 33])
@pytest.mark.parametrize(
    ("law", "name", "value", "code"),
    [
        ("nodes", "alpha1", np.nan, -2), ("nodes", "alpha1", -1.0, -3), ("nodes", "speed", 0.0, -4),
        ("own", "spin", np.inf, -2), ("own", "spin", 1e200, -2), ("own", "speed", 0.0, -4),
        ("given", "grain", 99.0, -11), ("nodes", "velocity", np.nan, -2),
        ("nodes", "wall_velocity", None, -3), ("nodes", "normal", 0.0, -5),
        ("own", "half_size", 9e-10, -6), ("own", "half_size", 101.0, -6),
        ("own", "roughness", np.nan, -7), ("own", "roughness", -1e-300, -7),
        ("nodes", "roughness", 0.5000001, -7), ("own", "omega", np.inf, -2),
        ("unspun", "grain", 0.3, -11),
        ("own", "inertia", -1e-300, -2), ("own", "inertia", np.inf, -2),
    ],
)  # fmt: skip
def test_a_row_with_an_error_is_nan_and_leaves_the_others_alone(
    library, bad, law, name, value, code
):
    draws = name in ("alpha1", "speed", "spin") or law == "given"
    rough = name in ("roughness", "grain")
    arrays = conditions(70, law) if draws else impacts(70, law, rough=rough)
    call = sample if draws else rebound
    with toolchain.opened(library, VECTORS / "spin.rbt") as table:
        whole = call(library, table, arrays, law)[2]
        for row in (bad, 60):
            # a wall that flees from the particle
            arrays[name][row] = -1e4 * arrays["normal"][row] if value is None else value
        first, codes, results = call(library, table, arrays, law)
    assert first == code
    assert np.flatnonzero(codes < 0).tolist() == [bad, 60]
    kept = results[[bad, 60]]
    if call is rebound and code == -3:  # the particle goes on
        np.testing.assert_array_equal(kept[:, :3], arrays["velocity"][[bad, 60]])
        assert not kept[:, 3:].any()
    else:
        assert np.isnan(kept).all()
    good = codes >= 0
    np.testing.assert_array_equal(results[good], whole[good])


def test_what_is_missing_is_an_error_and_nothing_is_written(library):
    """Tables, records and keys; arrays in records are left out in fuzz_calls.c."""
    states, index = np.full((3, 6), 7.0), np.arange(3, dtype=np.uint64)
    given = record(toolchain.Conditions, conditions(3, "given"))
    assert library.rbt_sample(None, 3, given, SEED, states, None) == -1
    given = record(toolchain.Impacts, impacts(3, "given"))
    after = record(toolchain.Rebounds, {"velocity": states})
    assert library.rbt_rebound(None, 3, given, SEED, after) == -1
    with toolchain.opened(library, VECTORS / "spin.rbt") as table:
        assert library.rbt_sample(table, 3, None, SEED, states, None) == -1
        assert library.rbt_rebound(table, 3, None, SEED, after) == -1
        assert library.rbt_grains(table, 3, SEED, None, None, states) == -1
        assert library.rbt_grains(table, 3, SEED, index, None, None) == -1
    assert (states == 7.0).all()
    assert [library.rbt_variables(None, None), library.rbt_has_spin_law(None)] == [0, 0]
    assert (library.rbt_covered(None, None), library.rbt_pair(None)) == (-1, b"")
    assert library.rbt_mean_half_size(None, 1.0) == 0.0
