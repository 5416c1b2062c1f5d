"""The torque of the gas on a spin: its law, its decay in time, and the same numbers in C."""

import ctypes

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import sampler
from sampler.library import library

D, RHO, MU = 100e-6, 1.2, 1.8e-5
STOKES = np.pi * MU * D**3
#: Of a sphere of corundum [kg m2], and the relaxation time of its spin in Stokes flow [s].
INERTIA = 3950.0 * np.pi / 60.0 * D**5
RELAXATION = INERTIA / STOKES
ALONG = np.array([0.48, -0.6, 0.64])


def spin(reynolds):
    """Angular velocities at rotational Reynolds numbers."""
    return np.asarray(reynolds)[..., None] * MU / (RHO * D * D) * ALONG


def over_stokes(reynolds):
    """Torque over that of Stokes."""
    omega = spin(reynolds)
    torque = sampler.gas_torque(omega, D, RHO, MU)
    np.testing.assert_allclose(np.cross(torque, omega), 0.0, atol=1e-15 * np.abs(torque).max() * 1e7)
    return -(torque @ ALONG) / (STOKES * (omega @ ALONG))


def in_c(name, *arguments):
    """What a function of the header writes for one particle; None is NULL."""
    numbers = ctypes.c_double * 3
    given = [
        x if x is None else numbers(*x) if np.ndim(x) else ctypes.c_double(x) for x in arguments
    ]
    result, call = numbers(), getattr(library(), name)
    call.restype = None
    call(*given, result)
    return np.array(result)


def test_the_law_is_that_of_the_literature():
    """Stokes' up to 32, 1.65 times that at 250, as (rho/2) (d/2)^5 C |slip| slip beyond."""
    np.testing.assert_allclose(over_stokes([1e-9, 1.0, 31.999]), 1.0, rtol=1e-14)
    assert over_stokes(250.0) == pytest.approx(1.653, abs=5e-4)
    assert over_stokes(32.001) == pytest.approx(1.00155, abs=1e-5)  # the jump
    # fits of Dennis et al. to their results, with R = Re / 4: 5.32 and 37.2 up to 20, 6.44 and 32.2
    # up to 50, 6.45 and 32.1 up to 100; between 4 and 80 the simpler form is up to 5 % below
    radius = np.array([15.0, 30.0, 75.0])
    fits = np.array([5.32, 6.44, 6.45]) / np.sqrt(radius) + np.array([37.2, 32.2, 32.1]) / radius
    np.testing.assert_allclose(over_stokes(4 * radius), fits * radius / (16 * np.pi), rtol=0.03)
    omega = spin(700.0)
    c_r = 12.9 / np.sqrt(700.0) + 128.4 / 700.0
    expected = -RHO / 2 * (D / 2) ** 5 * c_r * np.linalg.norm(omega) * omega
    np.testing.assert_allclose(sampler.gas_torque(omega, D, RHO, MU), expected, rtol=1e-14)


@pytest.mark.parametrize("reynolds", [10.0, 250.0, 4000.0])
def test_the_spin_decays_along_the_torque(reynolds):
    gas = spin(5.0)[::-1]
    omega, time = gas + spin(reynolds), 3.0 * RELAXATION

    def rate(_, w):
        return sampler.gas_torque(w, D, RHO, MU, gas) / INERTIA

    solved = solve_ivp(rate, (0.0, time), omega, rtol=1e-10, atol=1e-10)
    found = sampler.spin_after(omega, time, INERTIA, D, RHO, MU, gas)
    # the solver steps over the jump at 32
    np.testing.assert_allclose(found, solved.y[:, -1], rtol=1e-5)
    halves = omega
    for _ in range(2):
        halves = sampler.spin_after(halves, time / 2, INERTIA, D, RHO, MU, gas)
    np.testing.assert_allclose(halves, found, rtol=1e-13)


def test_no_time_step_overshoots():
    reynolds = np.logspace(-6, 8, 57)[:, None]
    times = np.append(0.0, np.logspace(-6, 4, 41)) * RELAXATION
    left = sampler.spin_after(spin(reynolds), times, INERTIA, D, RHO, MU) / spin(reynolds)
    assert (left >= 0.0).all()
    assert (np.diff(left, axis=1) <= 0.0).all()
    np.testing.assert_allclose(left[:, 0], 1.0, rtol=1e-15)
    assert (left[:, -1] == 0.0).all()


def test_c_gives_the_same_and_goes_back():
    gas = 1e4 * ALONG[::-1]
    for reynolds in (0.0, 1e-3, 31.0, 33.0, 250.0, 4000.0):
        omega = spin(reynolds)
        given = D, RHO, MU
        torque = sampler.gas_torque(omega, *given, gas)
        np.testing.assert_array_equal(in_c("rbt_gas_torque", omega, *given, gas), torque)
        for time in (0.0, 0.01 * RELAXATION, 5.0 * RELAXATION):
            after = sampler.spin_after(omega, time, INERTIA, *given)
            there = in_c("rbt_spin_after", omega, time, INERTIA, *given, None)
            np.testing.assert_allclose(there, after, rtol=1e-14)
            back = in_c("rbt_spin_after", there, -time, INERTIA, *given, None)
            np.testing.assert_allclose(back, omega, rtol=1e-11)
        far = in_c("rbt_spin_after", omega, -1e6 * RELAXATION, INERTIA, *given, None)
        assert np.linalg.norm(far) == pytest.approx(np.linalg.norm(spin(1e6 * (reynolds > 0.0))))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"diameter": [D, -D]}, r"diameter: got -0.0001 at index 1, allowed: a finite number abo"),
        ({"time": -1.0}, r"time: got -1, allowed: a finite number, 0 or more"),
        ({"inertia": 0.0}, r"inertia: got 0, allowed: a finite number above 0"),
        ({"omega": [1.0, 2.0]}, r"omega: got shape \(2,\), allowed: \(3,\) or \(..., 3\)"),
    ],
)
def test_wrong_arguments_are_refused(changed, message):
    given = {"omega": ALONG, "time": 1.0, "inertia": INERTIA, "diameter": D}
    with pytest.raises(sampler.InputError, match=f"^{message}"):
        sampler.spin_after(**{**given, "density": RHO, "viscosity": MU, **changed})
