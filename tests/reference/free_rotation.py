"""Free rotation computed independently: scipy integrates the rotation matrix."""

import numpy as np
from motion_fixtures import rotation_of
from scipy.integrate import solve_ivp


class FreeRotation:
    """Torque-free rotation of a motion over [0, duration].

    Integrates Euler's equations J W' = (J W) x W with R' = R [W], R from body to wall axes.
    """

    def __init__(self, moments, motion, duration):
        self._moments = tuple(float(j) for j in moments)
        start = np.concatenate([motion[0:3], rotation_of(motion).ravel()])
        rate = max(float(np.linalg.norm(motion[0:3])), 1e-3)
        solution = solve_ivp(
            self._derivative,
            (0.0, duration),
            start,
            method="DOP853",
            rtol=1e-13,
            atol=1e-13,
            max_step=0.2 / rate,
            dense_output=True,
        )
        assert solution.success
        assert solution.sol is not None
        self._dense = solution.sol

    def _derivative(self, _, y):
        j1, j2, j3 = self._moments
        w1, w2, w3, *r = y.tolist()
        angular = [(j2 - j3) / j1 * w2 * w3, (j3 - j1) / j2 * w3 * w1, (j1 - j2) / j3 * w1 * w2]
        # every row of R turns as a vector fixed in space does, seen from the body
        rows = [
            rate
            for a, b, c in (r[0:3], r[3:6], r[6:9])
            for rate in (b * w3 - c * w2, c * w1 - a * w3, a * w2 - b * w1)
        ]
        return np.array(angular + rows)

    def spin(self, times):
        """Angular velocity in body axes at (m,) times, (m, 3)."""
        return self._dense(times)[:3].T

    def rotation(self, times):
        """Orientation at (m,) times, (m, 3, 3)."""
        return self._dense(times)[3:].T.reshape(-1, 3, 3)
