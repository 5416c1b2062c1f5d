"""Judge measured numbers against an accuracy.

Every judged thing is a number, its error and a limit. It holds if the number less three errors is
within the limit (`tablegen.accuracy.metrics.Estimate.certain`).
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from tablegen.accuracy.metrics import Estimate
from tablegen.config.metric_table import METRICS, PRESETS, SPIN, SPIN_PRESETS, metric_of
from tablegen.config.targets import AccuracyTargets, SpinTargets

#: A number this many times its limit is a fault of the table, and no limit to declare.
_FAR = 2.0


class Measured(Protocol):
    """Distances measured somewhere."""

    @property
    def place(self) -> str:
        """Where, in words."""

    @property
    def estimates(self) -> Mapping[str, Estimate]:
        """Distances by limit."""


class Judged(NamedTuple):
    """The worst of the numbers that one limit holds for."""

    #: Name of the limit, with ``spin_`` if it is one of the spin law.
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
        """Distance from equal laws over what is allowed."""
        return metric_of(self.name).share(self.estimate.value, self.allowed)

    def within(self, allowed: float) -> bool:
        """Tell whether the number would be within another limit."""
        return self.estimate.certain <= allowed

    @property
    def line(self) -> str:
        """Number, error, place and limit in words."""
        text = metric_of(self.name).text
        return (
            f"{self.name}: {text(self.estimate.value)} (error {text(self.estimate.error)}) at "
            f"{self.place}, where {self.allowed:g} is allowed"
        )


def judge(
    measured: Sequence[Measured], targets: AccuracyTargets | SpinTargets, prefix: str = ""
) -> list[Judged]:
    """Find the worst number of each limit; none if nothing was measured."""
    judged = []
    for name in measured[0].estimates if measured else ():
        worst = max(measured, key=lambda one: one.estimates[name].certain)
        allowed = getattr(targets, name)
        judged.append(Judged(f"{prefix}{name}", worst.estimates[name], allowed, worst.place))
    return judged


def advice(numbers: Sequence[Judged]) -> str:
    """Say in one line what to change where some numbers do not hold.

    Where a number is more than `_FAR` times its limit, the line says where, and what to change in
    the table. Else it names limits to declare, a preset or a range.
    """
    missed = [number for number in numbers if not number.holds]
    far = [number for number in missed if not number.share <= _FAR]
    if far:
        laws = [[n for n in far if _law(n) == law] for law in _REMEDIES]
        worst = [max(some, key=lambda number: number.share) for some in laws if some]
        return "; ".join(_fault(number) for number in worst)
    changes = []
    for prefix, section in (("", "accuracy"), (SPIN, "spin_accuracy")):
        limits = [
            f"{number.name.removeprefix(SPIN)} = {_rounded_up(number)}"
            for number in missed
            if number.name.startswith(SPIN) == bool(prefix)
        ]
        changes += [f"{', '.join(limits)} in [{section}]"] if limits else []
    ways = [f"declare {' and '.join(changes)}"]
    ways += [f'preset = "{name}"' for name in reversed(PRESETS) if _holds_at(numbers, name)][:1]
    places = dict.fromkeys(number.place for number in missed if _at_condition(number))
    ways += [f"a range without {' and '.join(places)}"] if places else []
    return f"to hold: {'; or '.join(ways)}"


#: What to change where a law is far off: that of first impacts, the spin law at a condition without
#: spin, and the spin law along chains of hits.
_REMEDIES = {
    "first": "put a node there (alpha_nodes_deg or speed_nodes in [table]), or choose a range "
    "without this condition",
    "own": "give the spin law more leaves (spin_leaves in [table]), or choose a range without this "
    "condition",
    "chain": "give the spin law more leaves (spin_leaves in [table]); or, if particles meet one "
    "wall only, set spin = false",
}


def _law(number: Judged) -> str:
    """Name the law, and the kind of measurement, that a number is of: a key of `_REMEDIES`."""
    if not number.name.startswith(SPIN):
        return "first"
    return "own" if _at_condition(number) else "chain"


def _fault(number: Judged) -> str:
    """Say where a law is far off, by how much, and what to change."""
    metric, share = metric_of(number.name), number.share
    times = f"{share:.2g} times its limit" if math.isfinite(share) else "no number"
    return (
        f"{number.name} {metric.text(number.estimate.value)} at {number.place} is {times}: "
        f"{_REMEDIES[_law(number)]}"
    )


def _rounded_up(number: Judged) -> str:
    """Round a number up to two digits, but not above what there can be."""
    value = number.estimate.value
    if not math.isfinite(value):
        return "?"
    step = 10.0 ** (math.floor(math.log10(max(value, 1e-9))) - 1)
    return f"{min(math.ceil(value / step) * step, metric_of(number.name).most):.3g}"


def _at_condition(number: Judged) -> bool:
    """Tell whether a number is of a single condition."""
    return number.name.removeprefix(SPIN) in METRICS


def _holds_at(numbers: Sequence[Judged], preset: str) -> bool:
    """Tell whether all numbers would hold at a preset, which has no limits of chains."""
    limits = PRESETS[preset] | {SPIN + k: value for k, value in SPIN_PRESETS[preset].items()}
    return all(number.within(limits.get(number.name, number.allowed)) for number in numbers)
