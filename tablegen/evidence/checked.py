"""What must hold for every rebound of the stability study."""

from dataclasses import asdict, dataclass
from typing import Any, ClassVar


@dataclass(frozen=True, kw_only=True)
class Checked:
    """Rebounds of one kind: each must end, be finite, leave the wall, and gain no energy."""

    #: Of the particles, whose indices are the rows, and of the conditions if they are random.
    seed: int
    #: Number of rebounds.
    rebounds: int
    #: Rebounds that did not end or are not finite.
    unfinished: int
    #: Largest gain of energy over that before, and smallest v+ [V]; None if no rebound ended.
    growth: float | None
    least_velocity: float | None

    #: Energy that a rebound may gain by rounding, over that before.
    MOST_GROWTH: ClassVar[float] = 1e-9

    @property
    def failures(self) -> dict[str, str]:
        """Failures of the model by kind, a line each."""
        failures = {}
        if self.unfinished:
            failures["unfinished"] = f"{self.unfinished} of {self.rebounds} did not end"
        if self.growth is not None and self.growth > self.MOST_GROWTH:
            allowed = f"and may grow by {self.MOST_GROWTH:g}"
            failures["growing energy"] = f"energy grows by {self.growth:.3g}, {allowed}"
        if self.least_velocity is not None and self.least_velocity <= 0.0:
            speed = f"{self.least_velocity:.3g} V"
            failures["not leaving"] = f"a particle leaves with v+ = {speed}, not above 0"
        return failures

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON."""
        return {**asdict(self), "failures": list(self.failures.values())}
