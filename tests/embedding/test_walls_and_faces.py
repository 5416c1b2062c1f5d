"""What plugins take from the header: variables, ranges, moments, critical speeds, sums by face."""

import ctypes

import numpy as np
import pytest
import toolchain
from known_vectors import VECTORS
from sized_tables import sized_contents

import sampler
from sampler.formats.channels import VARIABLES
from sampler.formats.image import write_binary_table

SUMS = [
    "hits",
    "deposits",
    "mass",
    "energy_before",
    "energy_lost",
    "angle",
    "work_normal",
    "work_shear",
]
COUNT = 200


class FaceHit(ctypes.Structure):
    """`rbt_face_hit` of the header."""

    _fields_ = [
        ("number", ctypes.c_double),
        ("mass", ctypes.c_double),
        ("before", ctypes.c_double * 3),
        ("after", ctypes.c_double * 3),
        ("normal", ctypes.c_double * 3),
        ("works", ctypes.c_double * 2),
        ("stays", ctypes.c_int),
    ]


@pytest.fixture(scope="module")
def functions(library):
    """The library, with the functions of this file declared."""
    real, table = ctypes.c_double, ctypes.c_void_p
    for name, result, arguments in (
        ("rbt_has_variable", ctypes.c_int, (table, ctypes.c_int)),
        ("rbt_highest_speed", real, (table,)),
        ("rbt_critical_speed_at", real, (real, real, real)),
        ("rbt_moment_of_inertia", real, (table, *[ctypes.c_uint64] * 2, *[real] * 4)),
        ("rbt_half_size", real, (table, real, ctypes.c_void_p)),
        ("rbt_mean_inertia", real, (table, ctypes.c_void_p)),
        ("rbt_sphericity", real, (table, ctypes.c_void_p)),
        ("rbt_angle_bin", ctypes.c_int, (ctypes.POINTER(FaceHit),)),
        ("rbt_speed_bin", ctypes.c_int, (ctypes.POINTER(FaceHit), real)),
        ("rbt_add_face_hit", None, (ctypes.POINTER(FaceHit), ctypes.c_void_p)),
    ):
        getattr(library, name).restype = result
        getattr(library, name).argtypes = arguments
    return library


@pytest.fixture(scope="module")
def hits():
    """Hits at all angles, of which every third stays: records, and the same as arrays."""
    rng = np.random.default_rng(5)
    angle, speed = rng.uniform(0.01, 0.5 * np.pi, COUNT), rng.uniform(1.0, 400.0, COUNT)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, COUNT)
    along = np.cos(angle) * speed
    arrays = {
        "number": rng.uniform(1.0, 9.0, COUNT),
        "mass": rng.uniform(1e-12, 1e-9, COUNT),
        "before": np.stack(
            [along * np.cos(azimuth), -np.sin(angle) * speed, along * np.sin(azimuth)], axis=1
        ),
        "after": rng.normal(0.0, 50.0, (COUNT, 3)),
        "normal": np.tile([0.0, 1.0, 0.0], (COUNT, 1)),
        "works": rng.uniform(0.0, 10.0, (COUNT, 2)),
        "stays": np.arange(COUNT) % 3 == 0,
    }
    arrays["after"][arrays["stays"]] = 0.0
    records = []
    for k in range(COUNT):
        hit = FaceHit(number=arrays["number"][k], mass=arrays["mass"][k], stays=k % 3 == 0)
        for name in ("before", "after", "normal", "works"):
            getattr(hit, name)[:] = arrays[name][k]
        records.append(hit)
    return records, arrays, np.degrees(angle), speed


def sums_of(functions, records, wanted):
    """Add hits to the sums that are wanted, and return all sums."""
    sums = np.zeros(len(SUMS))
    addresses = [sums.ctypes.data + 8 * k if name in wanted else 0 for k, name in enumerate(SUMS)]
    pointers = np.array(addresses, dtype=np.uintp)
    for hit in records:
        functions.rbt_add_face_hit(hit, pointers.ctypes.data)
    return dict(zip(SUMS, sums, strict=True))


def test_sums_of_a_face(functions, hits):
    records, arrays, angle, speed = hits
    number = arrays["number"]
    mass = number * arrays["mass"]
    after = (arrays["after"] ** 2).sum(axis=1)
    expected = {
        "hits": number.sum(),
        "deposits": number[arrays["stays"]].sum(),
        "mass": mass.sum(),
        "energy_before": (0.5 * mass * speed**2).sum(),
        "energy_lost": (0.5 * mass * (speed**2 - after)).sum(),
        "angle": np.average(angle, weights=number),
        "work_normal": mass @ arrays["works"][:, 0],
        "work_shear": mass @ arrays["works"][:, 1],
    }
    assert sums_of(functions, records, SUMS) == pytest.approx(expected, rel=1e-12)


def test_sums_that_are_not_wanted_are_left_out(functions, hits):
    records, arrays, *_ = hits
    sums = sums_of(functions, records, ["mass", "angle"])
    assert sums["mass"] == pytest.approx((arrays["number"] * arrays["mass"]).sum())
    assert [sums[name] for name in SUMS if name != "mass"] == [0.0] * 7  # a mean needs the hits


def test_bins_of_a_face(functions, hits):
    records, _, angle, speed = hits
    bins = [functions.rbt_angle_bin(hit) for hit in records]
    np.testing.assert_array_equal(bins, np.minimum(angle / 9.0, 9.0).astype(int))
    bins = [functions.rbt_speed_bin(hit, 300.0) for hit in records]
    np.testing.assert_array_equal(bins, np.minimum(speed / 30.0, 9.0).astype(int))
    assert (speed > 300.0).any()


def test_variables_and_highest_speed(functions):
    for name, variables, speed in (
        ("plane", ("u", "v", "omega_z"), 120.0),
        ("full", sampler.load("corundum-steel").columns, None),
    ):
        with toolchain.opened(functions, VECTORS / f"{name}.rbt") as table:
            has = [functions.rbt_has_variable(table, k) for k in range(len(VARIABLES))]
            columns = np.zeros(len(VARIABLES), np.int32)
            n = functions.rbt_variables(table, columns)
            assert np.flatnonzero(has).tolist() == sorted(columns[:n])
            assert {VARIABLES[k] for k in np.flatnonzero(has)} >= set(variables)
            assert [functions.rbt_has_variable(table, k) for k in (-1, 10, 99)] == [0, 0, 0]
            if speed:
                assert functions.rbt_highest_speed(table) == speed
    assert functions.rbt_has_variable(None, 0) == functions.rbt_highest_speed(None) == 0


def test_critical_speed_at_another_diameter(functions):
    speed = functions.rbt_critical_speed_at(40e-6, 0.5, 10e-6)
    assert speed == pytest.approx(0.5 * 0.25 ** (10.0 / 7.0))
    brach = [sampler.critical_speed(d, 2650.0, 70e9, 0.2, 210e9, 0.3) for d in (10e-6, 40e-6)]
    assert functions.rbt_critical_speed_at(40e-6, brach[0], 10e-6) == pytest.approx(brach[1])
    assert functions.rbt_critical_speed_at(40e-6, 0.5, 0.0) == 0.5


def test_moment_of_inertia(functions):
    """Of the inertia that is known, else of the grain, else of the sphere of equal volume."""
    mass, half_size, diameter = 2e-10, 40e-6, 60e-6
    with toolchain.opened(functions, VECTORS / "spin.rbt") as table:
        grain = np.zeros(3)
        index = np.array([5], np.uint64)
        assert functions.rbt_grains(table, 1, 7, index, None, grain) == 0
        sizes = mass, half_size, diameter
        known = functions.rbt_moment_of_inertia(table, 7, 5, 0.3, *sizes)
        assert known == pytest.approx(0.3 * mass * half_size**2)
        drawn = functions.rbt_moment_of_inertia(table, 7, 5, 0.0, *sizes)
        moment = sampler.mean_inertia(sampler.load(VECTORS / "spin.h5"), grain)
        assert drawn == pytest.approx(moment * mass * half_size**2)
    with toolchain.opened(functions, VECTORS / "full.rbt") as table:  # without a spin law
        sphere = functions.rbt_moment_of_inertia(table, 7, 5, 0.0, *sizes)
        assert sphere == pytest.approx(0.1 * mass * diameter**2)


def test_sizes_of_grains_in_c_are_those_in_python(functions, tmp_path):
    """Of shapes and meshes; the mean agrees with that over many grains in the tests of Python."""
    contents = sized_contents()
    write_binary_table(tmp_path / "sized.rbt", contents)
    sized = sampler.Table(contents)
    grains = np.unique(sized.grains(7, np.arange(200)), axis=0)
    assert len(grains) == len(contents["spin/shape_codes"])
    with toolchain.opened(functions, tmp_path / "sized.rbt") as table:
        for grain in grains:
            at = grain.ctypes.data
            assert functions.rbt_half_size(table, 6e-5, at) == sampler.half_size(sized, 6e-5, grain)
            assert functions.rbt_mean_inertia(table, at) == sampler.mean_inertia(sized, grain)
            assert functions.rbt_sphericity(table, at) == sampler.sphericity(sized, grain)
        mean = functions.rbt_mean_half_size(table, 6e-5)
        assert mean == pytest.approx(sized.mean_half_size(6e-5), rel=1e-12)
        of_none = np.array([9.0, 1.0, 1.0])
        assert functions.rbt_half_size(table, 6e-5, of_none.ctypes.data) == 0.0
        assert functions.rbt_half_size(None, 6e-5, grains[0].ctypes.data) == 0.0
