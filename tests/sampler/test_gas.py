"""The torque of the gas on a spin: its law, its decay in time, and the same numbers in C."""

import ctypes

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sampler
import sampler.numba as compiled
from sampler.library import library

D, RHO, MU = GAS = 100e-6, 1.2, 1.8e-5
STOKES = np.pi * MU * D**3
#: Of a sphere of corundum [kg m2], and the relaxation time of its spin in Stokes flow [s].
INERTIA = 3950.0 * np.pi / 60.0 * D**5
RELAXATION = INERTIA / STOKES
ALONG = np.array([0.48, -0.6, 0.64])


def spin(reynolds):
    """Angular velocities at rotational Reynolds numbers."""
    return np.asarray(reynolds)[..., None] * MU / (RHO * D * D) * ALONG


def in_c(name, *arguments):
    """What a function of the header writes for one particle; None is NULL."""
    numbers, call = ctypes.c_double * 3, getattr(library(), name)
    result, call.restype = numbers(), None
    vectors = [numbers(*x) if np.ndim(x) else x for x in arguments]
    call(*(ctypes.c_double(x) if isinstance(x, float) else x for x in vectors), result)
    return np.array(result)


def test_the_law_is_that_of_the_literature():
    """At users' 250 it is 1.65 times that of Stokes; it jumps at 32."""
    reynolds = np.array([1e-9, 1.0, 31.999, 32.001, 250.0])
    over_stokes = -sampler.gas_torque(spin(reynolds), *GAS) / (STOKES * spin(reynolds))
    expected = np.array([1.0, 1.0, 1.0, 1.00155, 1.65306])[:, None]
    np.testing.assert_allclose(over_stokes, np.tile(expected, 3), atol=1e-5)
    c_r, omega = 12.9 / np.sqrt(700.0) + 128.4 / 700.0, spin(700.0)
    expected = -RHO / 2 * (D / 2) ** 5 * c_r * np.linalg.norm(omega) * omega
    np.testing.assert_allclose(sampler.gas_torque(omega, *GAS), expected, rtol=1e-14)


@pytest.mark.parametrize("reynolds", [10.0, 250.0, 4000.0])
def test_the_spin_decays_along_the_torque(reynolds):
    gas, time = spin(5.0)[::-1], 3.0 * RELAXATION
    omega = gas + spin(reynolds)
    solved = solve_ivp(
        lambda _, w: sampler.gas_torque(w, *GAS, gas) / INERTIA, (0.0, time), omega, rtol=1e-10
    )
    found = sampler.spin_after(omega, time, INERTIA, *GAS, gas)
    np.testing.assert_allclose(found, solved.y[:, -1], rtol=1e-5)  # it steps over the jump at 32
    half = sampler.spin_after(omega, time / 2, INERTIA, *GAS, gas)
    halves = sampler.spin_after(half, time / 2, INERTIA, *GAS, gas)
    np.testing.assert_allclose(halves, found, rtol=1e-13)


def test_no_time_step_overshoots():
    reynolds = np.logspace(-6, 8, 57)[:, None]
    times = np.append(0.0, np.logspace(-6, 4, 41)) * RELAXATION
    left = sampler.spin_after(spin(reynolds), times, INERTIA, *GAS) / spin(reynolds)
    assert (left >= 0.0).all()
    assert (np.diff(left, axis=1) <= 0.0).all()
    np.testing.assert_allclose(left[:, 0], 1.0, rtol=1e-15)
    assert (left[:, -1] == 0.0).all()


@pytest.mark.parametrize("reynolds", [0.0, 1e-3, 31.0, 33.0, 250.0, 4000.0])
def test_c_gives_the_same_and_goes_back(reynolds):
    omega, gas = spin(reynolds), 1e4 * ALONG[::-1]
    torque = sampler.gas_torque(omega, *GAS, gas)
    np.testing.assert_array_equal(in_c("rbt_gas_torque", omega, *GAS, gas), torque)
    np.testing.assert_array_equal(compiled.gas_torque(tuple(omega), *GAS, tuple(gas)), torque)
    for time in (0.0, 0.01 * RELAXATION, 5.0 * RELAXATION):
        there = in_c("rbt_spin_after", omega, time, INERTIA, *GAS, None)
        after = sampler.spin_after(omega, time, INERTIA, *GAS)
        np.testing.assert_allclose(there, after, rtol=1e-14)
        back = in_c("rbt_spin_after", there, -time, INERTIA, *GAS, None)
        np.testing.assert_allclose(back, omega, rtol=1e-11)
    far = in_c("rbt_spin_after", omega, -1e6 * RELAXATION, INERTIA, *GAS, None)
    np.testing.assert_allclose(far, spin(1e6) * (reynolds > 0.0), rtol=1e-9)


def test_wrong_arguments_are_refused():
    with pytest.raises(sampler.InputError, match=r"^diameter: got -1 at index 1, allowed: a fin"):
        sampler.gas_torque(ALONG, [D, -1.0], RHO, MU)
    with pytest.raises(sampler.InputError, match=r"^time: got -1, allowed: a finite number, 0 or"):
        sampler.spin_after(ALONG, -1.0, INERTIA, *GAS)
    with pytest.raises(sampler.InputError, match=r"^omega: got shape \(2,\), allowed: \(3,\) or"):
        sampler.gas_torque([1.0, 2.0], *GAS)
