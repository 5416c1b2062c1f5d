"""What a table covers, as numbers and in words."""

import math
from typing import NamedTuple

from sampler.formats.bounds import ANY_SPEED

Ends = tuple[float, float]


class Covered(NamedTuple):
    """Range of the angles, speeds and spins that lie inside a table; `str` writes it in words.

    The speed of a particle that spins counts as V (1 + k spin^2)^(1/2). This is the speed that the
    particle would have if all of its kinetic energy were translation.
    """

    #: Impact angles of the law of first impacts [degrees], and speeds [m/s]; None: any speed.
    alpha_deg: Ends
    speed: Ends | None
    #: Size of the spin before the impact times a/V; None: the table has no spin law.
    spin: Ends | None
    #: Speeds between which the laws of the pair were measured [m/s]; None: the pair states none.
    measured: Ends | None
    #: Impact angles of the spin law [degrees]; None: those of `alpha_deg`.
    spin_alpha_deg: Ends | None = None

    def __str__(self) -> str:
        low, high = self.alpha_deg
        parts = [f"{low:g} to {high:g} deg" if low > 0.0 else "any angle"]
        if self.spin_alpha_deg is not None:
            others = f"{ends_text(self.spin_alpha_deg)} deg"
            parts = [f"{others} (fresh grains without spin: {parts[0]})"]
        if self.speed is not None:
            parts += [f"{ends_text(self.speed)} m/s"]
        elif self.measured is not None:
            parts += [f"any speed (measured at {ends_text(self.measured)} m/s)"]
        else:
            parts += ["any speed (the speed of the measurements is not known)"]
        if self.spin is not None:
            least, most = self.spin
            sizes = f"spin to {most:g}" if least == 0.0 else f"spin {ends_text(self.spin)}"
            parts += [sizes if most < 1e9 else "any spin"]
        return ", ".join(parts)


def ends_text(ends: Ends) -> str:
    """Write the ends of a range as text; a range of one value is that value."""
    low, high = ends
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def make_covered(
    ends: dict[str, Ends], has_spin: bool, spin_alpha_deg: Ends | None = None
) -> Covered:
    """Make `Covered` of what ``rbt_covered`` gives, without the rounding of units."""
    low, high = (round(math.degrees(end), 12) for end in ends["alpha1"])
    speed, measured = (
        None if ends[name][1] >= ANY_SPEED[1] else ends[name] for name in ("speed", "measured")
    )
    least, most = ends["spin"]
    spin = (round(least, 9), round(most, 9)) if has_spin else None
    other = spin_alpha_deg if spin_alpha_deg != (low, high) else None
    return Covered((low, high), speed, spin, measured, other)
