"""The stability study in a few dozen numbers: by group, and the worst case of each quantity."""

from collections.abc import Callable, Iterator, Sequence
from statistics import fmean as mean
from typing import NamedTuple

from tablegen.evidence.cases import FORMS, Case
from tablegen.evidence.outcome import Figures, Outcome

#: What is shown where nothing was measured.
_NONE = "-"

#: Heads of the columns of `group_rows`.
HEAD = (
    "cases of",
    "cases",
    "particles",
    "failed",
    "coll.",
    "us",
    "worst us",
    "growth",
    "residual",
    "drift",
    "depth",
    "contact",
    "flight",
)

#: What the columns mean, for a reader of text or of a page.
LEGEND = (
    "*: every case is outside the speeds in which the restitution law was measured.",
    "coll.: most collisions of a particle.",
    "us: microseconds a rebound takes one thread, mean of the cases and worst case.",
    "growth: largest gain of energy. residual: of the collision equations.",
    "drift: of energy or angular momentum in flight, relative. depth: below the wall, in a.",
    "contact, flight: mean change of a particle's state, in V and V/a, by half the contact",
    "resolution and by half the flight tolerance.",
)


class Group(NamedTuple):
    """Outcomes with something in common."""

    name: str
    outcomes: list[Outcome]


class Extreme(NamedTuple):
    """Worst case of a quantity."""

    quantity: str
    value: float
    outcome: Outcome


def _split(outcomes: Sequence[Outcome], title: Callable[[Case], str]) -> Iterator[Group]:
    """Give groups with equal titles, in the order in which the titles are met."""
    groups: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault(title(outcome.case), []).append(outcome)
    for name, members in groups.items():
        mark = " *" if all(outcome.extrapolated for outcome in members) else ""
        yield Group(name + mark, members)


def groups(outcomes: Sequence[Outcome]) -> list[Group]:
    """Split outcomes by shape, form, angle, speed and size of the spin; all of them come last.

    Parameters
    ----------
    outcomes : sequence of Outcome

    Returns
    -------
    list of Group
        A group in which every case extrapolates the restitution law is marked with a star.
    """
    forms = sorted(outcomes, key=lambda o: FORMS.index(o.case.form))
    spins = sorted(outcomes, key=lambda o: abs(o.case.spin))
    return [
        *_split(outcomes, lambda case: case.shape),
        *_split(forms, lambda case: case.form),
        *_split(outcomes, lambda case: f"{case.alpha_deg:g} degrees"),
        *_split(outcomes, lambda case: f"{case.speed:g} m/s"),
        *_split(spins, lambda case: f"spin {abs(case.spin):g} V/a"),
        Group("all", list(outcomes)),
    ]


def _text(reduce: Callable[[list[float]], float], values: list[float], form: str = ".1e") -> str:
    return f"{reduce(values):{form}}" if values else _NONE


def group_row(group: Group) -> list[str]:
    """Cells of one group, for the columns of `HEAD`."""
    figures = [o.figures for o in group.outcomes if o.figures is not None]
    costs = [1e6 * o.cost for o in group.outcomes if o.cost is not None]
    return [
        group.name,
        f"{len(group.outcomes):,}",
        f"{sum(o.particles for o in group.outcomes):,}",
        f"{sum(bool(o.failures) for o in group.outcomes):,}",
        _text(max, [f.most_collisions for f in figures], ","),
        _text(mean, costs, ",.1f"),
        _text(max, costs, ",.0f"),
        _text(max, [f.growth for f in figures]),
        _text(max, [f.residual for f in figures]),
        _text(max, [f.drift for f in figures]),
        _text(max, [f.depth for f in figures]),
        _text(mean, [f.contact.mean for f in figures if f.contact is not None]),
        _text(mean, [f.flight.mean for f in figures if f.flight is not None]),
    ]


def group_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Cells of all groups."""
    return [group_row(group) for group in groups(outcomes)]


#: Quantities and how a case measures them; None where it does not. Of the last, the least counts.
_LEAST_VELOCITY = "least v+ [V]"
_QUANTITIES: dict[str, Callable[[Outcome, Figures], float | None]] = {
    "collisions": lambda _, f: f.most_collisions,
    "cost [us]": lambda o, _: None if o.cost is None else 1e6 * o.cost,
    "energy growth": lambda _, f: f.growth,
    "residual": lambda _, f: f.residual,
    "flight drift": lambda _, f: f.drift,
    "depth [a]": lambda _, f: f.depth,
    "contact change": lambda _, f: None if f.contact is None else f.contact.mean,
    "flight change": lambda _, f: None if f.flight is None else f.flight.mean,
    _LEAST_VELOCITY: lambda _, f: f.least_velocity,
}


def extremes(outcomes: Sequence[Outcome]) -> list[Extreme]:
    """Worst case of each quantity, for those that were measured.

    Parameters
    ----------
    outcomes : sequence of Outcome

    Returns
    -------
    list of Extreme
    """
    worst = []
    for name, measure in _QUANTITIES.items():
        found = [
            Extreme(name, value, o)
            for o in outcomes
            if o.figures is not None and (value := measure(o, o.figures)) is not None
        ]
        if found:
            choose = min if name == _LEAST_VELOCITY else max
            worst.append(choose(found, key=lambda extreme: extreme.value))
    return worst
