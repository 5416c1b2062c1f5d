"""Python gives the states of the known-answer vectors; binary tables are those of the tables."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sampler.drawing.frames import rebound
from sampler.drawing.kernel import draw
from small_tables import SMALL_TABLES
from spin_vectors import spin_lines

from sampler.formats.channels import VARIABLES
from sampler.formats.hdf5 import read_table
from sampler.formats.image import binary_table, table_arrays
from tablegen.model.roughness import rough_rebound

pytestmark = pytest.mark.processor

VECTORS = Path(__file__).resolve().parents[1] / "vectors"


def read_cases(name):
    """Cases of a file: kind, given numbers, keys, code, expected numbers."""
    for line in (VECTORS / f"{name}.txt").read_text(encoding="ascii").splitlines():
        kind, *words = line.split()
        n = {"draw": 2, "rebound": 10, "rough-rebound": 11}[kind]
        given = [float.fromhex(word) for word in words[:n]]
        seed, index, hit, code = (int(word) for word in words[n : n + 4])
        keys = np.uint64(seed), np.uint64(index), np.uint32(hit)
        expected = [float.fromhex(word) for word in words[n + 4 :]]
        # a table without the work of the impulses gives 0 for it
        yield kind, given, keys, code, expected + [0.0] * (2 * (len(expected) == 8))


def result_of(arrays, kind, given, keys):
    if kind == "draw":
        out = np.zeros(len(VARIABLES))
        return draw(arrays, *given, *keys, out), out
    out = np.zeros(6)
    v, n, a, wall = tuple(given[:3]), tuple(given[3:6]), given[6], tuple(given[7:10])
    if kind == "rebound":
        code = rebound(arrays, v, n, a, wall, *keys, out)
    else:
        code = rough_rebound(arrays, v, n, a, wall, given[10], *keys, out)
    return code, out if code >= 0 else np.zeros(6)


def check(arrays, name):
    """The bits of every draw, and of rebounds all but the last digits."""
    codes = set()
    for kind, given, keys, code, expected in read_cases(name):
        got, values = result_of(arrays, kind, given, keys)
        codes.add(code)
        assert got == code
        # rebounds call functions of the C library, which differ in the last digits
        allowed = {"draw": 0.0, "rebound": 1e-13, "rough-rebound": 1e-12}[kind]
        np.testing.assert_allclose(
            values[:3], expected[:3], rtol=0, atol=allowed * size(expected[:3])
        )
        np.testing.assert_allclose(
            values[3:], expected[3:], rtol=0, atol=allowed * size(expected[3:])
        )
    assert codes == {0, 1, -1, -2, -3, -4, -5, -8}


def size(values):
    return max(1.0, *np.abs(values))


def arrays_of(name):
    return table_arrays(read_table(VECTORS / f"{name}.h5"))


@pytest.mark.parametrize("name", SMALL_TABLES)
def test_same_bits(name):
    check(arrays_of(name), name)


def test_same_bits_of_particles_that_arrive_spinning():
    found = spin_lines(read_table(VECTORS / "spin.h5"))
    expected = (VECTORS / "spin.txt").read_text(encoding="ascii").splitlines()
    assert len(found) == len(expected) == 160
    for line, wanted in zip(found, expected, strict=True):
        words, others = line.split(), wanted.split()
        if words[0] == "spin-draw":
            assert words == others
            continue
        # a last digit of an angle may turn the last digit of a feature, in single precision
        assert words[:-6] == others[:-6]
        values, known = (np.array([float.fromhex(x) for x in row[-6:]]) for row in (words, others))
        for part in (slice(0, 3), slice(3, 6)):
            error = 1e-5 * size(known[part])
            np.testing.assert_allclose(values[part], known[part], rtol=0, atol=error)


@pytest.mark.parametrize("name", [*SMALL_TABLES, "spin"])
def test_binary_tables_are_those_of_the_tables(name):
    written = binary_table(read_table(VECTORS / f"{name}.h5"))
    assert written == (VECTORS / f"{name}.rbt").read_bytes()


def test_a_wrong_table_gives_other_states():
    with pytest.raises(AssertionError):
        check(arrays_of("plane"), "full")


def test_the_last_bit_of_one_cubic_gives_other_states():
    arrays = arrays_of("full")
    normals = arrays.normals.copy()
    normals[:, 0] = np.nextafter(normals[:, 0], np.float32(9.0))
    with pytest.raises(AssertionError):
        check(arrays._replace(normals=normals), "full")


def assert_same_table(found, expected):
    """Equal but for the functions that made the numbers, whose last digits are a processor's.

    Powers, the normal distribution function and Cholesky factors of well-conditioned matrices: a
    few units in the last place, so one step where a number was rounded to single precision or to
    a step of 1/4096 or 1/65536.
    """
    assert found.attributes == expected.attributes
    assert found.datasets.keys() == expected.datasets.keys()
    for path, wanted in expected.datasets.items():
        values = found[path]
        assert (values.dtype, values.shape) == (wanted.dtype, wanted.shape), path
        if path in ("dependence/alias_index", "dependence/first_of_class"):
            np.testing.assert_array_equal(values, wanted, path)
        elif wanted.dtype.kind in "iu":
            assert np.abs(values.astype(int) - wanted.astype(int)).max() <= 1, path
        else:
            precision = {"rtol": 2.0 * np.finfo(wanted.dtype).eps, "atol": 1e-14}
            if wanted.dtype == np.float64:
                precision = {"rtol": 1e-13, "atol": 1e-14}
            np.testing.assert_allclose(values, wanted, **precision, err_msg=path)


@pytest.mark.parametrize("name", SMALL_TABLES)
def test_tables_are_those_of_the_script(name):
    assert_same_table(read_table(VECTORS / f"{name}.h5"), SMALL_TABLES[name]())


@pytest.mark.parametrize(
    ("path", "change"),
    [
        ("axes/alpha_coordinate", 1e-11),
        ("marginals/quantiles", 1e-6),
        ("dependence/mean", 2),
        ("dependence/cholesky", 2),
        ("dependence/alias_probability", 2),
        ("dependence/alias_index", 1),
    ],
)
def test_a_table_of_another_script_is_seen(path, change):
    made = SMALL_TABLES["full"]()
    values = made[path].copy()
    # a quantile may grow where it is the largest
    k = values.size - 1 if path == "marginals/quantiles" else values.size // 2
    up = values.flat[k] + change
    values.flat[k] = up if path != "dependence/alias_index" else (values.flat[k] + 1) % 5
    other = replace(made, datasets={**made.datasets, path: values})
    assert_same_table(made, made)
    with pytest.raises(AssertionError):
        assert_same_table(other, made)
