"""The stability study in a few dozen numbers: by group, and the worst case of each quantity."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from tablegen.studies.stability.cases import FORMS, Case
from tablegen.studies.stability.outcome import Change, Figures, Outcome

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


def _small(values: Sequence[float]) -> str:
    return f"{max(values):.1e}" if values else _NONE


def _mean(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.1e}" if values else _NONE


def group_row(group: Group) -> list[str]:
    """Cells of one group, for the columns of `HEAD`."""
    figures = [o.figures for o in group.outcomes if o.figures is not None]
    costs = [1e6 * o.cost for o in group.outcomes if o.cost is not None]
    return [
        group.name,
        f"{len(group.outcomes):,}",
        f"{sum(o.particles for o in group.outcomes):,}",
        f"{sum(bool(o.failures) for o in group.outcomes):,}",
        f"{max(f.most_collisions for f in figures):,}" if figures else _NONE,
        f"{sum(costs) / len(costs):,.1f}" if costs else _NONE,
        f"{max(costs):,.0f}" if costs else _NONE,
        _small([f.growth for f in figures]),
        _small([f.residual for f in figures]),
        _small([f.drift for f in figures]),
        _small([f.depth for f in figures]),
        _mean([f.contact.mean for f in figures if f.contact is not None]),
        _mean([f.flight.mean for f in figures if f.flight is not None]),
    ]


def group_rows(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Cells of all groups."""
    return [group_row(group) for group in groups(outcomes)]


def _largest(
    name: str, outcomes: Sequence[Outcome], value: Callable[[Outcome, Figures], float | None]
) -> Extreme | None:
    """Case with the largest value; None if no case has one."""
    found = [
        Extreme(name, size, o)
        for o in outcomes
        if o.figures is not None and (size := value(o, o.figures)) is not None
    ]
    return max(found, key=lambda extreme: extreme.value, default=None)


def _mean_of(change: Change | None) -> float | None:
    return None if change is None else change.mean


def extremes(outcomes: Sequence[Outcome]) -> list[Extreme]:
    """Worst case of each quantity, for those that were measured.

    Parameters
    ----------
    outcomes : sequence of Outcome

    Returns
    -------
    list of Extreme
    """
    worst = [
        _largest("collisions", outcomes, lambda _, f: f.most_collisions),
        _largest("cost [us]", outcomes, lambda o, _: None if o.cost is None else 1e6 * o.cost),
        _largest("energy growth", outcomes, lambda _, f: f.growth),
        _largest("residual", outcomes, lambda _, f: f.residual),
        _largest("flight drift", outcomes, lambda _, f: f.drift),
        _largest("depth [a]", outcomes, lambda _, f: f.depth),
        _largest("contact change", outcomes, lambda _, f: _mean_of(f.contact)),
        _largest("flight change", outcomes, lambda _, f: _mean_of(f.flight)),
    ]
    slowest = _largest("v+", outcomes, lambda _, f: -f.least_velocity)
    if slowest is not None:
        worst.append(Extreme("least v+ [V]", -slowest.value, slowest.outcome))
    return [extreme for extreme in worst if extreme is not None]
