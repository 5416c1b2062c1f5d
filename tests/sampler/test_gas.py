"""The torque of the gas on a spin: its law, and its decay in time."""

import ctypes

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import solve_ivp

import sampler
from sampler.library import library

D, RHO, MU = GAS = 100e-6, 1.2, 1.8e-5
STOKES = np.pi * MU * D**3
#: Of a sphere of corundum [kg m2], and the relaxation time of its spin in Stokes flow [s].
MOMENT = 3950.0 * np.pi / 60.0 * D**5
RELAXATION = MOMENT / STOKES
ALONG = np.array([0.48, -0.6, 0.64])


def spin(reynolds):
    """Angular velocities at rotational Reynolds numbers."""
    return np.asarray(reynolds)[..., None] * MU / (RHO * D * D) * ALONG


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
        lambda _, w: sampler.gas_torque(w, *GAS, gas) / MOMENT, (0.0, time), omega, rtol=1e-10
    )
    omega_after = sampler.spin_after(omega, time, MOMENT, *GAS, gas)
    np.testing.assert_allclose(
        omega_after, solved.y[:, -1], rtol=1e-5
    )  # it steps over the jump at 32
    half = sampler.spin_after(omega, time / 2, MOMENT, *GAS, gas)
    halves = sampler.spin_after(half, time / 2, MOMENT, *GAS, gas)
    np.testing.assert_allclose(halves, omega_after, rtol=1e-13)


def test_no_time_step_overshoots():
    reynolds = np.logspace(-6, 8, 57)[:, None]
    times = np.append(0.0, np.logspace(-6, 4, 41))[None] * RELAXATION
    left = sampler.spin_after(spin(reynolds), times, MOMENT, *GAS) / spin(reynolds)
    assert (left >= 0.0).all()
    assert (np.diff(left, axis=1) <= 0.0).all()
    np.testing.assert_allclose(left[:, 0], 1.0, rtol=1e-15)
    assert (left[:, -1] == 0.0).all()


@pytest.mark.parametrize("reynolds", [0.0, 1e-3, 31.0, 33.0, 250.0, 4000.0])
def test_c_goes_back_in_time(reynolds):
    numbers, call = ctypes.c_double * 3, library().rbt_spin_after
    call.restype = None

    def back(omega, time):
        omega_after, given = numbers(), map(ctypes.c_double, (-time, MOMENT, *GAS))
        call(numbers(*omega), *given, None, omega_after)
        return np.array(omega_after)

    omega = spin(reynolds)
    for time in (0.0, 0.01 * RELAXATION, 5.0 * RELAXATION):
        after = sampler.spin_after(omega, time, MOMENT, *GAS)
        np.testing.assert_allclose(back(after, time), omega, rtol=1e-11)
    far = back(omega, 1e6 * RELAXATION)
    np.testing.assert_allclose(far, spin(1e6) * (reynolds > 0.0), rtol=1e-9)


def test_a_gas_without_viscosity_has_no_torque():
    gas = (D, RHO, 0.0)
    np.testing.assert_array_equal(sampler.gas_torque([[1e5, 0.0, 0.0], [0.0] * 3], *gas), 0.0)
    np.testing.assert_array_equal(sampler.spin_after(1e5 * ALONG, 1.0, MOMENT, *gas), 1e5 * ALONG)
    # and nearly none has nearly none
    nearly = sampler.spin_after(1e5 * ALONG, 1.0, MOMENT, D, RHO, 1e-300)
    np.testing.assert_allclose(nearly, 1e5 * ALONG, rtol=1e-12)


@pytest.mark.parametrize(
    "change",
    [
        {"diameter": [D, -1.0]},
        *({"time": time} for time in (-1.0, np.ones((4, 1)))),
        *({"omega": omega} for omega in ([1.0, 2.0], [0.0, np.nan, 0.0])),
        {"gas_rotation": [np.inf] * 3},
        {"viscosity": np.nan},
        {"density": [1.0, 2.0]},
    ],
)
def test_wrong_arguments_are_refused(change):
    given = {"omega": np.ones((4, 3)), "time": 1.0, "moment": MOMENT, "diameter": D}
    refused(*change, sampler.spin_after, **given | {"density": RHO, "viscosity": MU} | change)
