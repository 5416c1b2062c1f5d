"""Collision under Coulomb friction, integrated in the normal impulse by scipy.

Readable and slow: u, v and the work are followed by DOP853 from one event to the next. The model
uses another variable, series of its own and other events.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

#: Slide over the contact speed that counts as rest.
REST = 1e-10


class Outcome:
    """Impulse and work of a collision, and whether it slid, stuck, slipped anew or jammed."""

    def __init__(self, start, mobility):
        self.start, self.mobility = np.array(start), mobility
        self.seen = set()

    def finish(self, state):
        """Take the impulse from a final state (u, w, v, work, s)."""
        change = np.array([state[0], state[2], state[1]]) - self.start
        self.work, self.normal = state[3], state[4]
        self.velocity = np.array([state[0], state[2], state[1]])
        block = self.mobility[np.ix_([0, 2], [0, 2])]
        side = np.linalg.solve(block, change[[0, 2]] - self.mobility[[0, 2], 1] * self.normal)
        self.impulse = np.array([side[0], self.normal, side[1]])
        return self


def slip_angle(mobility, friction):
    """Direction in which a contact slides on from rest, by scanning the circle."""
    block, pull = mobility[np.ix_([0, 2], [0, 2])], mobility[[0, 2], 1]

    def turning(angle):
        e = np.array([np.cos(angle), np.sin(angle)])
        q = pull - friction * block @ e
        return q[1] * e[0] - q[0] * e[1]

    angles = np.linspace(0.0, 2.0 * np.pi, 721) + 1e-3
    values = np.array([turning(a) for a in angles])
    for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        angle = brentq(turning, angles[i], angles[i + 1], xtol=1e-15)
        e = np.array([np.cos(angle), np.sin(angle)])
        if e @ (pull - friction * block @ e) > 0.0:
            return e
    raise AssertionError("no direction")


def collide(mobility, velocity, static, dynamic, restitution, resolution):
    """Follow one collision; an `Outcome`.

    Parameters
    ----------
    mobility : (3, 3) float64
        A of dV_c = A S, axes x, y (normal), z.
    velocity : sequence of three floats
        Contact velocity, (u, v, w).
    static, dynamic, restitution, resolution : float
    """
    block, pull = mobility[np.ix_([0, 2], [0, 2])], mobility[[0, 2], 1]
    size = np.linalg.norm(velocity)
    out = Outcome(velocity, mobility)
    hold = np.linalg.solve(block, pull)
    state = np.array([velocity[0], velocity[2], velocity[1], 0.0, 0.0])
    least, compresses, mode = 0.0, True, "slides"
    while True:
        if np.hypot(*state[:2]) <= REST * size:
            state[:2] = 0.0
            held = np.linalg.norm(hold) <= static
            mode = "sticks" if held else "slips anew"
            fixed = hold if held else dynamic * slip_angle(mobility, dynamic)
        out.seen.add(mode)

        def rates(s, y, mode=mode, fixed=None if mode == "slides" else fixed):
            side = dynamic * y[:2] / np.hypot(*y[:2]) if fixed is None else fixed
            along = pull - block @ side if mode != "sticks" else np.zeros(2)
            return [*along, mobility[1, 1] - pull @ side, y[2], 1.0]

        def part(v, work, least=least):
            return work - (1.0 - restitution**2) * least

        def turns(s, y):
            return y[2]

        def ends(s, y, least=least):
            falls = rates(s, y)[2] < 0.0
            done = part(y[2], y[3]) if falls else min(part(y[2], y[3]), y[2] - resolution)
            return max(done, y[3])

        def rests(s, y):
            return np.hypot(*y[:2]) - 0.5 * REST * size

        events = [turns] if compresses else [ends, turns]
        turns.terminal = ends.terminal = rests.terminal = True
        turns.direction = 1.0 if compresses else -1.0
        ends.direction = 1.0
        if mode == "slides":
            events.append(rests)
        solved = solve_ivp(
            rates, (0.0, 10.0 * size), state, "DOP853", events=events, rtol=1e-12, atol=1e-14
        )
        if np.any(np.diff(solved.y[2]) < -1e-12):
            out.seen.add("jams")
        met = [bool(len(t)) for t in solved.t_events]
        state = solved.y[:, -1].copy()
        if not any(met):
            raise AssertionError(f"no end: {solved.message}")
        if compresses and met[0]:
            least, state[2], compresses = min(least, state[3]), 0.0, False
        elif not compresses and met[0]:
            return out.finish(state)
        elif not compresses and met[1]:
            state[2], compresses = 0.0, True
            out.seen.add("is compressed again")
