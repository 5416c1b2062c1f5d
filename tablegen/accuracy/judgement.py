"""Judge measured distances against the limits of an accuracy.

A number holds if

    number - 3 error <= limit

where the error is that of `tablegen.accuracy.metrics`. If the true distance is within the limit,
the number misses it with a probability of at most 1 in 700.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from tablegen.accuracy.metrics import Estimate
from tablegen.config.metric_table import METRICS, PRESETS, SPIN, SPIN_PRESETS, metric_of
from tablegen.config.targets import AccuracyTargets, SpinTargets

#: If a number is more than this many times its limit, the table is at fault. The advice is then to
#: change the table, not to declare a larger limit.
_FAR_FACTOR = 2.0


class HasDistances(Protocol):
    """Distances measured at a condition or at hits of a chain."""

    @property
    def place(self) -> str:
        """Condition or hits in words."""

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """Distances by the names of the limits, without ``spin_``."""


class Judged(NamedTuple):
    """Worst of the numbers that have the same limit."""

    #: Name of the limit; it begins with ``spin_`` if it is of the spin law.
    name: str
    estimate: Estimate
    allowed: float
    place: str

    @property
    def holds(self) -> bool:
        """Whether the number is within the limit."""
        return self.within(self.allowed)

    @property
    def share(self) -> float:
        """Distance from equal laws over the allowed distance from equal laws."""
        return metric_of(self.name).share(self.estimate.value, self.allowed)

    def within(self, allowed: float) -> bool:
        """Return whether the number is within a limit."""
        return self.estimate.certain <= allowed

    @property
    def line(self) -> str:
        """Number, error, place and limit as a sentence."""
        text = metric_of(self.name).text
        return (
            f"{self.name}: {text(self.estimate.value)} (error {text(self.estimate.error)}) at "
            f"{self.place}, where {self.allowed:g} is allowed"
        )


def judge(
    measured: Sequence[HasDistances], targets: AccuracyTargets | SpinTargets, prefix: str = ""
) -> list[Judged]:
    """Find the worst number of each limit; return an empty list if nothing was measured.

    The worst number is the one with the largest number - 3 error. ``prefix`` stands before the
    names of the limits: "spin_" for those of the spin law.
    """
    judged = []
    for name in measured[0].estimates if measured else ():
        worst = max(measured, key=lambda one: one.estimates[name].certain)
        allowed = getattr(targets, name)
        judged.append(Judged(f"{prefix}{name}", worst.estimates[name], allowed, worst.place))
    return judged


def advice(numbers: Sequence[Judged]) -> str:
    """Return one line on what to change if some numbers do not hold.

    If a number is more than `_FAR_FACTOR` times its limit, the line says where, and what to change
    in the table. Otherwise it names limits, a preset or a range that the configuration could
    declare.
    """
    missed = [number for number in numbers if not number.holds]
    far = [number for number in missed if not number.share <= _FAR_FACTOR]
    if far:
        laws = [[n for n in far if _law(n) == law] for law in _REMEDIES]
        worst = [max(some, key=lambda number: number.share) for some in laws if some]
        return " ".join(_fault(number) for number in worst)
    changes = []
    for prefix, section in (("", "accuracy"), (SPIN, "spin_accuracy")):
        limits = [
            f"{number.name.removeprefix(SPIN)} = {_rounded_up(number)}"
            for number in missed
            if number.name.startswith(SPIN) == bool(prefix)
        ]
        changes += [f"{', '.join(limits)} in [{section}]"] if limits else []
    ways = [f"declare {' and '.join(changes)}"]
    ways += [f'set preset = "{name}"' for name in reversed(PRESETS) if _holds_at(numbers, name)][:1]
    places = dict.fromkeys(number.place for number in missed if _at_condition(number))
    ways += [f"choose a range without {' and '.join(places)}"] if places else []
    return f"To make it hold, {'; or '.join(ways)}."


#: What to change if a number is far above its limit. The number is one of the law of first impacts,
#: of the spin law at a condition without spin, or of the spin law along chains of hits.
_REMEDIES = {
    "first": "Put a node there (alpha_nodes_deg or speed_nodes in [table]), or choose a range "
    "without this condition.",
    "own": "Give the spin law more leaves (spin_leaves in [table]), or choose a range without this "
    "condition.",
    "chain": "Give the spin law more leaves (spin_leaves in [table]). If each particle meets one "
    "wall only, set spin = false instead.",
}


def _law(number: Judged) -> str:
    """Return which law was measured, and where, as a key of `_REMEDIES`."""
    if not number.name.startswith(SPIN):
        return "first"
    return "own" if _at_condition(number) else "chain"


def _fault(number: Judged) -> str:
    """Return where a number is far above its limit, by how much, and what to change."""
    metric, share = metric_of(number.name), number.share
    times = f"{share:.2g} times its limit" if math.isfinite(share) else "not a number"
    return (
        f"{number.name} {metric.text(number.estimate.value)} at {number.place} is {times}. "
        f"{_REMEDIES[_law(number)]}"
    )


def _rounded_up(number: Judged) -> str:
    """Round a number up to two digits, but not above the largest possible distance."""
    value = number.estimate.value
    if not math.isfinite(value):
        return "?"
    step = 10.0 ** (math.floor(math.log10(max(value, 1e-9))) - 1)
    return f"{min(math.ceil(value / step) * step, metric_of(number.name).most):.3g}"


def _at_condition(number: Judged) -> bool:
    """Return whether a number was measured at one condition, not along a chain."""
    return number.name.removeprefix(SPIN) in METRICS


def _holds_at(numbers: Sequence[Judged], preset: str) -> bool:
    """Return whether all numbers would hold at a preset; it does not change limits of chains."""
    limits = PRESETS[preset] | {SPIN + k: value for k, value in SPIN_PRESETS[preset].items()}
    return all(number.within(limits.get(number.name, number.allowed)) for number in numbers)
