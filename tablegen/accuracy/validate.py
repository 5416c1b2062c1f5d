"""Whether a table holds the accuracy that it declares, or that its user wants."""

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sampler
from sampler.arguments import as_integer, told_apart
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison, Spin
from tablegen.accuracy.conditions import check_conditions, pick_conditions
from tablegen.accuracy.decision import FALSE_ALARMS, FALSE_HOLDS, Verdict, judge, limits
from tablegen.accuracy.measure import measure
from tablegen.accuracy.node_screening import SAMPLES, Screening, screen
from tablegen.accuracy.requested import asked_accuracy, asked_spin_accuracy
from tablegen.accuracy.spin_conditions import (
    SpinCondition,
    check_spin_conditions,
    pick_spin_conditions,
)
from tablegen.accuracy.spin_measure import measure_spin
from tablegen.accuracy.spin_validation import SpinValidation, judged_record
from tablegen.config.config import AccuracyTargets, Config, stored_config
from tablegen.config.defaults import VALIDATE_CONDITIONS, VALIDATE_SPIN_CONDITIONS
from tablegen.config.metric_table import (
    METRICS,
    looser_than_compact,
    worst_spin_stored,
    worst_stored,
)

#: A condition of the user's choice: angle [degrees], speed [m/s], and spin [V/a] if it has one.
Place = tuple[float, float] | tuple[float, float, Spin]

#: Bits of a seed that nobody gave: few enough to type.
_SEED_BITS = 32


@dataclass(frozen=True)
class Validation:
    """Outcome of a validation.

    Attributes
    ----------
    table : str
        Name or path that was given.
    content_sha256 : str
        Checksum of what was measured.
    seed : int
        Repeats the validation.
    declared : AccuracyTargets
        What the table's configuration declares.
    asked : AccuracyTargets
        What it was held against: the declared accuracy unless the user asked for another.
    stored : dict of float, or None
        Worst distance of each metric that the file stores, as it says of itself; None if nothing.
    screening : Screening or None
        The coarse test of all nodes; None if only conditions of the user's choice were measured.
    comparisons : list of Comparison
        At conditions between the nodes, or at those of the user's choice.
    nodes : list of Comparison
        At the nodes that looked worst in the coarse test.
    missed, undecided : list of str
        One line for each distance that is larger than asked for, or that could not be told from it.
    spin : SpinValidation or None
        The same of the spin law; None if the table has none, or nothing of it was looked at.
    """

    table: str
    content_sha256: str
    seed: int
    declared: AccuracyTargets
    asked: AccuracyTargets
    stored: dict[str, float] | None
    screening: Screening | None
    comparisons: list[Comparison]
    nodes: list[Comparison]
    missed: list[str]
    undecided: list[str]
    spin: SpinValidation | None = None

    @property
    def holds(self) -> bool:
        """Whether everything that was looked at has the accuracy, noise allowed for."""
        return not self.missed and not self.undecided

    @property
    def measured(self) -> list[Comparison]:
        """All comparisons, those at nodes last."""
        return [*self.comparisons, *self.nodes]

    @property
    def together(self) -> int:
        """How many comparisons are judged together."""
        return len(self.measured) + (self.spin.measured.count if self.spin else 0)

    @property
    def surpassed(self) -> dict[str, float]:
        """Errors that are, noise allowed for, above the worst that the file stores."""
        found = {}
        for name, worst in (self.stored or {}).items():
            least = (limits(name, c.estimates[name], self.together)[0] for c in self.measured)
            found[name] = max(least, default=0.0)
            # noise may take what is stored below the distance of equal laws
            if found[name] <= max(worst, METRICS[name].least):
                del found[name]
        return found

    @property
    def lenient(self) -> list[str]:
        """Distances for which less is declared than by the preset "compact"."""
        return looser_than_compact(self.declared.model_dump())

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready dictionary with every number."""
        of_spin = None if self.spin is None else self.spin.to_dict(self.together)
        return {
            "table": self.table,
            "content_sha256": self.content_sha256,
            "seed": self.seed,
            "software_version": sampler.__version__,
            "declared": self.declared.model_dump(),
            "asked": self.asked.model_dump(),
            "stored": self.stored,
            "false_alarms": FALSE_ALARMS,
            "false_holds": FALSE_HOLDS,
            "holds": self.holds,
            "missed": self.missed,
            "undecided": self.undecided,
            "screening": None if self.screening is None else self.screening.to_dict(),
            "conditions": [self._record(c) for c in self.comparisons],
            "nodes": [self._record(c) for c in self.nodes],
            "spin": of_spin,
        }

    def _record(self, comparison: Comparison) -> dict[str, Any]:
        """Record a comparison for JSON, with confidence limits and verdict of each distance."""
        judged = judged_record(comparison.estimates, self.asked, self.together)
        return comparison.to_dict() | {"estimates": judged}


def validate(
    name_or_path: str | Path,
    *,
    conditions: int = VALIDATE_CONDITIONS,
    spin_conditions: int = VALIDATE_SPIN_CONDITIONS,
    seed: int | None = None,
    samples: int | None = None,
    accuracy: str | None = None,
    at: Sequence[Place] | None = None,
    progress: bool = False,
) -> Validation:
    """Compare a table with new direct simulation: every node coarsely, some conditions finely.

    A spin law, if the table has one, is compared at spinning conditions, and over the impacts that
    occur in chains of them.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a table that comes with the package, or path of a .h5 file.
    conditions : int
        Number of conditions between nodes, 1 or more; see `pick_conditions`.
    spin_conditions : int
        Number of spinning conditions, see `pick_spin_conditions`; 0 leaves out the spin law.
    seed : int, optional
        Chooses the conditions and all random numbers, 0 to 2**64 - 1; another one each time if
        None.
    samples : int, optional
        States a side at each condition, and of the chains, 1000 or more; by default as many as the
        accuracy needs. Where these do not decide, up to nine times as many are taken.
    accuracy : str, optional
        What the table is held against: a preset, "compact", "standard" or "fine", or limits such
        as "ks=0.01,spin_auc=0.6", which change the declared ones. By default what it declares.
    at : sequence of (alpha_deg, speed) or (alpha_deg, speed, spin), optional
        Only these conditions, angles in degrees, speeds in m/s and spins times a/V; nodes and
        chains are not tested then.
    progress : bool
        Show progress bars on standard error.

    Raises
    ------
    InputError
        If the file is not a table, does not agree with its own configuration, or an argument is
        out of range.
    """
    seed = secrets.randbits(_SEED_BITS) if seed is None else seed
    _check_arguments(conditions, spin_conditions, samples, seed)
    # read once: the checksum is that of what is measured, whatever becomes of the file meanwhile
    contents = read_table(find_table(name_or_path))
    config = stored_config(contents.config, f"{name_or_path}: config")
    check_agreement(contents, config, str(name_or_path))
    asked = asked_accuracy(config.accuracy, accuracy)
    asked_spin = asked_spin_accuracy(config.spin_targets, accuracy)
    table, few = Table(contents), min(SAMPLES, samples or SAMPLES)
    how: Any = {"seed": seed, "samples": samples, "progress": progress}
    screening, spinning = None, _spinning(contents, config, at, spin_conditions, seed)
    if at is not None:
        places = check_conditions(table, [(p[0], p[1]) for p in at if len(p) == 2], len(at))
    else:
        places = pick_conditions(table, conditions, seed)
        screening = screen(table, config, asked, **how | {"samples": few})
    suspects = screening.suspects if screening else ()
    found = measure(table, config, [*places, *suspects], targets=asked, **how)
    spin = None
    if spinning:
        law = measure_spin(table, config, spinning, targets=asked_spin, joint=at is None, **how)
        stored = worst_spin_stored(contents.datasets)
        spin = SpinValidation(law, config.spin_targets, asked_spin, stored)
    verdict, of_spin = _verdicts(found, asked, spin)
    return Validation(
        table=str(name_or_path),
        content_sha256=contents.content_sha256,
        seed=seed,
        declared=config.accuracy,
        asked=asked,
        stored=worst_stored(table.accuracy),
        screening=screening,
        comparisons=found[: len(places)],
        nodes=found[len(places) :],
        missed=[*(screening.missed if screening else ()), *verdict.missed, *of_spin.missed],
        undecided=verdict.undecided + of_spin.undecided,
        spin=spin,
    )


def _spinning(
    contents: TableContents, config: Config, at: Sequence[Place] | None, count: int, seed: int
) -> list[SpinCondition]:
    """Give the spinning conditions to measure at; refuse chosen ones that the table cannot have."""
    if at is None:
        return pick_spin_conditions(config, count, seed) if contents.has_spin else []
    chosen = [SpinCondition(*p) for p in at if len(p) == 3]
    if chosen and not contents.has_spin:
        raise InputError("at: got a spin, allowed: none, of a table without a spin law")
    return check_spin_conditions(contents, chosen)


def _verdicts(
    found: Sequence[Comparison], asked: AccuracyTargets, spin: SpinValidation | None
) -> tuple[Verdict, Verdict]:
    """Judge what was measured of both laws, all of it together."""
    if spin is None:
        return judge(found, asked), Verdict([], [])
    together = len(found) + spin.measured.count
    return judge(found, asked, together), spin.measured.judged(spin.asked, together)


def _check_arguments(conditions: int, spin_conditions: int, samples: int | None, seed: int) -> None:
    """Refuse what is no integer, or out of range."""
    as_integer("conditions", conditions, 1, 2**63 - 1, "1 or more")
    as_integer("spin_conditions", spin_conditions, 0, 2**63 - 1, "0 or more")
    if samples is not None:
        as_integer("samples", samples, 1000, 2**63 - 1, "1000 or more")
    as_integer("seed", seed, 0, 2**64 - 1, "0 to 2**64 - 1")


def check_agreement(contents: TableContents, config: Config, origin: str) -> None:
    """Refuse a table that contradicts its configuration: of another pair, range or components.

    Parameters
    ----------
    contents : TableContents
    config : Config
        Read from the table.
    origin : str
        Name of the table, to open an error message.

    Raises
    ------
    InputError
    """
    if contents.pair != config.pair_name:
        raise InputError(
            f"{origin}: pair: got '{contents.pair}', allowed: '{config.pair_name}', the pair of "
            "the table's configuration"
        )
    for name, nodes, span in (
        ("alpha_deg", contents["axes/alpha_deg"], config.domain.alpha_deg),
        ("speed", contents["axes/speed"], config.domain.speed),
    ):
        if (float(nodes[0]), float(nodes[-1])) != span:
            got = " to ".join(told_apart(end, *span, digits=6) for end in nodes[[0, -1]].tolist())
            raise InputError(
                f"{origin}: axes/{name}: got {got}, allowed: {span[0]:g} to {span[1]:g}, "
                "the domain of the table's configuration"
            )
    if contents.variables != config.domain.columns:
        raise InputError(
            f"{origin}: components: got {' '.join(contents.variables)}, allowed: "
            f"{' '.join(config.domain.columns)}, those of the table's configuration"
        )
    if contents.has_spin != config.spin:
        got, allowed = ("a", "none") if contents.has_spin else ("no", "one")
        raise InputError(
            f"{origin}: spin: got {got} spin law, allowed: {allowed}, as the table's "
            "configuration says"
        )
