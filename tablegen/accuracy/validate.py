"""Validate a table: measure it, and judge whether it holds the declared or requested accuracy."""

import secrets
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import sampler
from sampler.arguments import as_integer
from sampler.errors import InputError
from sampler.files import find_table
from sampler.formats.hdf5 import TableContents, read_table
from sampler.table import Table
from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.conditions import (
    Place,
    check_conditions,
    pick_conditions,
    pick_own_conditions,
)
from tablegen.accuracy.decision import FALSE_ALARMS, FALSE_HOLDS, Verdict, judged_record, limits
from tablegen.accuracy.joint_law import JointComparison
from tablegen.accuracy.measure import LawAccuracy, measure, measure_spin
from tablegen.accuracy.node_screening import SAMPLES, Screening, screen
from tablegen.config.config import AccuracyTargets, Config, stored_config
from tablegen.config.defaults import VALIDATE_CONDITIONS
from tablegen.config.metric_table import metric_of, worst_spin_stored, worst_stored
from tablegen.config.targets import SpinTargets, asked_accuracy

#: Bits of a random seed: few enough to type.
_SEED_BITS = 32


@dataclass(frozen=True)
class ValidatedLaw:
    """Measurement of one law, with the accuracy it is held against."""

    measured: LawAccuracy
    declared: AccuracyTargets | SpinTargets
    #: Declared accuracy unless the user asked for another.
    asked: AccuracyTargets | SpinTargets
    #: Worst distance of each limit in the table file; None if it stores none.
    stored: dict[str, float] | None

    @property
    def worst(self) -> dict[str, float]:
        """Largest measured distance of each limit, noise included."""
        return {n: max(e.value for e in found) for n, found in self.measured.estimates().items()}

    def surpassed(self, together: int) -> dict[str, float]:
        """Give the errors that are above the worst stored ones by more than noise."""
        found = {}
        for name, estimates in self.measured.estimates().items():
            least = max(limits(name, estimate, together)[0] for estimate in estimates)
            stored = (self.stored or {}).get(name, least)
            # noise may take the stored distance below that of equal laws
            if least > max(stored, metric_of(name).least):
                found[name] = least
        return found

    def to_dict(self, together: int) -> dict[str, Any]:
        """Give every number for JSON; ``together`` comparisons are judged together."""

        def record(comparison: Comparison | JointComparison, asked: Any) -> dict[str, Any]:
            judged = judged_record(comparison.estimates, asked, together)
            return comparison.to_dict() | {"estimates": judged}

        found = self.measured
        common = {
            "declared": self.declared.model_dump(),
            "asked": self.asked.model_dump(),
            "stored": self.stored,
            "conditions": [record(c, self.asked) for c in found.comparisons],
        }
        if isinstance(self.asked, AccuracyTargets):
            return common | {"nodes": [record(c, self.asked) for c in found.nodes]}
        later = [later.to_dict() for later in (*found.cells, *found.hits)]
        joint = found.joint and record(found.joint, self.asked.joint)
        return common | {"joint": joint, "later": later}


@dataclass(frozen=True)
class Validation:
    """Result of a validation."""

    #: Name or path of the table, and checksum of the measured contents.
    table: str
    content_sha256: str
    #: Repeats the validation.
    seed: int
    #: Coarse test of all nodes; None if only chosen conditions were measured.
    screening: Screening | None
    #: First-impact law, and spin law; None if the table has none or nothing of it was measured.
    law: ValidatedLaw
    spin: ValidatedLaw | None = None

    @property
    def comparisons(self) -> list[Comparison]:
        """Comparisons of the first-impact law between the nodes, or at chosen conditions."""
        return self.law.measured.comparisons

    @property
    def laws(self) -> list[ValidatedLaw]:
        """All measured laws."""
        return [self.law, self.spin] if self.spin else [self.law]

    @property
    def together(self) -> int:
        """Number of comparisons that are judged together."""
        return sum(law.measured.count for law in self.laws)

    @property
    def verdict(self) -> Verdict:
        """Distances that are larger than asked for, or cannot be told from that."""
        verdict = Verdict(list(self.screening.missed) if self.screening else [], [])
        for law in self.laws:
            verdict += law.measured.judged(law.asked, self.together)
        return verdict

    @property
    def missed(self) -> list[str]:
        """One line for each distance that is larger than asked for."""
        return self.verdict.missed

    @property
    def undecided(self) -> list[str]:
        """One line for each distance that cannot be told from the accuracy asked for."""
        return self.verdict.undecided

    @property
    def holds(self) -> bool:
        """Whether everything measured has the accuracy, noise allowed for."""
        return not self.missed and not self.undecided

    def to_dict(self) -> dict[str, Any]:
        """Give every number for JSON."""
        return {
            "table": self.table,
            "content_sha256": self.content_sha256,
            "seed": self.seed,
            "software_version": sampler.__version__,
            "false_alarms": FALSE_ALARMS,
            "false_holds": FALSE_HOLDS,
            "holds": self.holds,
            "missed": self.missed,
            "undecided": self.undecided,
            "screening": self.screening and asdict(self.screening),
            **self.law.to_dict(self.together),
            "spin": self.spin and self.spin.to_dict(self.together),
        }


def validate(
    name_or_path: str | Path,
    *,
    conditions: int = VALIDATE_CONDITIONS,
    seed: int | None = None,
    samples: int | None = None,
    accuracy: str | None = None,
    at: Sequence[tuple[float, float]] | None = None,
    progress: bool = False,
) -> Validation:
    """Compare a table with new direct simulation: every node coarsely, some conditions finely.

    A spin law is compared without spin, over the impacts of chains, in cells of conditions and at
    every hit of chains, with direct simulation that keeps the orientation of a grain.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a table that comes with the package, or path of a .h5 file.
    conditions : int
        Number of conditions between nodes, 1 or more, for each law.
    seed : int, optional
        Selects the conditions and all random numbers, 0 to 2**64 - 1; random by default.
    samples : int, optional
        States a side at each condition, and of the chains, 1000 or more; by default as many as the
        accuracy needs. Up to nine times as many where the verdict is undecided.
    accuracy : str, optional
        Accuracy that the table is held against: a preset, "compact", "standard" or "fine", or
        limits such as "ks=0.01,spin_auc=0.6". By default the declared accuracy.
    at : sequence of (alpha_deg, speed), optional
        Only these conditions of the first-impact law, degrees and m/s; neither nodes nor the spin
        law are tested then.
    progress : bool
        Show progress bars on standard error.

    Raises
    ------
    InputError
        If the file is not a table, does not agree with its own configuration, or an argument is
        out of range.
    """
    seed = secrets.randbits(_SEED_BITS) if seed is None else seed
    as_integer("conditions", conditions, 1, 2**63 - 1, "1 or more")
    as_integer("samples", 1000 if samples is None else samples, 1000, 2**63 - 1, "1000 or more")
    as_integer("seed", seed, 0, 2**64 - 1, "0 to 2**64 - 1")
    # read once, so that the checksum is that of the measured contents
    contents = read_table(find_table(name_or_path))
    if contents.of_spheres:
        allowed = "one of nodes; `tablegen validate` compares spheres impact by impact"
        raise InputError(f"{name_or_path}: got a table of spheres, allowed: {allowed}")
    config = stored_config(contents.config, f"{name_or_path}: config")
    _check_agreement(contents, config, str(name_or_path))
    how: dict[str, Any] = {"accuracy": accuracy, "at": at, "progress": progress}
    return validate_contents(
        contents, config, str(name_or_path), conditions, seed, samples=samples, **how
    )


def validate_contents(
    contents: TableContents,
    config: Config,
    name: str,
    conditions: int,
    seed: int,
    *,
    samples: int | None = None,
    accuracy: str | None = None,
    at: Sequence[tuple[float, float]] | None = None,
    progress: bool = False,
) -> Validation:
    """Validate the contents of a table, called ``name``; the other arguments as for `validate`.

    `tablegen.tables.generate.generate` ends with it, so that both judge alike.
    """
    table = Table(contents)
    asked = asked_accuracy(config.accuracy, accuracy)
    asked_spin = asked_accuracy(config.spin_targets, accuracy)
    how: dict[str, Any] = {"seed": seed, "progress": progress}
    screening, suspects = None, []
    if at is None:
        places = pick_conditions(table, conditions, seed)
        own = pick_own_conditions(table, conditions if table.has_spin else 0, seed)
        screening = screen(table, config, asked, samples=min(SAMPLES, samples or SAMPLES), **how)
        suspects = [Place(*node) for node in screening.suspects]
    else:
        places, own = check_conditions(table, [Place(*place) for place in at]), []
    how["samples"] = samples
    found = measure(table, config, [*places, *suspects], targets=asked, **how)
    law = LawAccuracy(found[: len(places)], tuple(found[len(places) :]))
    spin = None
    if own:
        over = measure_spin(table, config, own, targets=asked_spin, **how)
        stored = worst_spin_stored(contents.datasets)
        spin = ValidatedLaw(over, config.spin_targets, asked_spin, stored)
    return Validation(
        table=name,
        content_sha256=contents.content_sha256,
        seed=seed,
        screening=screening,
        law=ValidatedLaw(law, config.accuracy, asked, worst_stored(table.accuracy)),
        spin=spin,
    )


def _check_agreement(contents: TableContents, config: Config, origin: str) -> None:
    """Refuse a table that contradicts its own configuration."""

    def span(axis: str) -> str:
        return " to ".join(f"{end:.9g}" for end in contents[f"axes/{axis}"][[0, -1]].tolist())

    domain, speeds = config.domain, "{:.9g} to {:.9g}".format(*config.domain.speed)
    if contents.speed_independent:
        speeds = span("speed")
    for field, got, allowed in (
        ("pair", contents.pair, config.pair_name),
        ("axes/alpha_deg", span("alpha_deg"), "{:.9g} to {:.9g}".format(*domain.alpha_deg)),
        ("axes/speed", span("speed"), speeds),
        ("components", " ".join(contents.variables), " ".join(domain.columns)),
        ("spin law", "one" if contents.has_spin else "none", "one" if config.spin else "none"),
    ):
        if got != allowed:
            raise InputError(
                f"{origin}: {field}: got {got}, allowed: {allowed}, as in the table's configuration"
            )
