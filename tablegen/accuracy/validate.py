"""Validate a table: measure it, and judge whether it holds an accuracy.

The map of the steps is in `tablegen.accuracy`.
"""

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
from tablegen.accuracy.chains import LaterHit
from tablegen.accuracy.comparison import Comparison
from tablegen.accuracy.conditions import (
    ComparedCondition,
    check_conditions,
    pick_conditions,
    pick_own_conditions,
)
from tablegen.accuracy.judgement import Judged, judge
from tablegen.accuracy.measure import measure, measure_chains, sample_size
from tablegen.config.config import AccuracyTargets, Config, stored_config
from tablegen.config.defaults import VALIDATE_CONDITIONS
from tablegen.config.metric_table import SPIN, worst_stored
from tablegen.config.targets import SpinTargets, asked_accuracy

#: Number of bits of a random seed. The user may have to type the seed.
_SEED_BITS = 32


@dataclass(frozen=True)
class Validation:
    """Comparisons of a table with direct simulation, and their judgement; from `validate`.

    Attributes
    ----------
    table : str
        Name or path of the table.
    content_sha256 : str
        Checksum of the contents that were measured.
    seed : int
        Seed of the conditions and of all random numbers. The same seed gives the same validation.
    config : Config
        Configuration of the table, with the accuracy that it declares.
    asked : AccuracyTargets
        Limits of the law of first impacts: the declared ones, unless others were asked for.
    asked_spin : SpinTargets
        Limits of the spin law: the declared ones, unless others were asked for.
    stored : dict of float
        Worst number of each limit that is stored in the table file.
    comparisons : list of Comparison
        Comparisons of the law of first impacts, by condition.
    own : list of Comparison
        Comparisons of the spin law at conditions without spin; empty if the table has no spin law.
    hits : list of LaterHit
        Comparisons of the spin law along chains of hits; empty if the table has no spin law.
    """

    table: str
    content_sha256: str
    seed: int
    config: Config
    asked: AccuracyTargets
    asked_spin: SpinTargets
    stored: dict[str, float]
    comparisons: list[Comparison]
    own: list[Comparison]
    hits: list[LaterHit]

    @property
    def numbers(self) -> list[Judged]:
        """Worst number of each limit."""
        return [
            *judge(self.comparisons, self.asked),
            *judge(self.own, self.asked_spin, SPIN),
            *judge(self.hits, self.asked_spin, SPIN),
        ]

    @property
    def missed(self) -> list[Judged]:
        """Numbers beyond their limits."""
        return [number for number in self.numbers if not number.holds]

    @property
    def holds(self) -> bool:
        """Whether all numbers are within their limits."""
        return not self.missed

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as a dictionary for JSON."""
        numbers = [
            {
                "name": number.name,
                **asdict(number.estimate),
                "limit": number.allowed,
                "holds": number.holds,
                "place": number.place,
                "stored": self.stored.get(number.name),
            }
            for number in self.numbers
        ]
        return {
            "table": self.table,
            "content_sha256": self.content_sha256,
            "seed": self.seed,
            "software_version": sampler.__version__,
            "holds": self.holds,
            "numbers": numbers,
            "conditions": [c.to_dict() for c in (*self.comparisons, *self.own)],
            "chains": [hit.to_dict() for hit in self.hits],
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
    """Compare a table with new direct simulation, and judge its accuracy.

    The law of first impacts is compared at conditions between the nodes. The spin law, if the table
    has one, is compared at other conditions without spin, and along chains of sixty hits.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a table that comes with the package, or path of a .h5 file.
    conditions : int, optional
        Number of conditions for each law, 1 or more.
    seed : int, optional
        Seed of the conditions and of all random numbers, 0 to 2**64 - 1. By default it is random;
        the result names it.
    samples : int, optional
        Number of states at each condition, from the table and from direct simulation each, and of
        grains of each shape in chains, 1000 or more. By default it is as large as the accuracy
        needs.
    accuracy : str, optional
        Accuracy to judge the table by: a preset ("compact", "standard" or "fine"), or limits such
        as "ks=0.01,spin_auc=0.6". By default it is the accuracy that the table declares.
    at : sequence of (alpha_deg, speed), optional
        Conditions [degrees, m/s] at which to compare the law of first impacts instead. The spin law
        is not compared then.
    progress : bool, optional
        Whether to show progress bars on standard error.

    Returns
    -------
    Validation
        All comparisons. `Validation.holds` says whether the table is as accurate as it should be.

    Raises
    ------
    InputError
        If the file is not a table, if it does not agree with its own configuration, if it is a
        table of spheres, or if an argument is out of range.

    Notes
    -----
    docs/accuracy.md explains the distances, and when a table passes.

    Examples
    --------
    A validation takes minutes, so this example is not run by the tests:

    >>> from tablegen import validate
    >>> result = validate("corundum-steel", conditions=2, seed=1)  # doctest: +SKIP
    >>> result.holds  # doctest: +SKIP
    True
    """
    seed = secrets.randbits(_SEED_BITS) if seed is None else seed
    as_integer("conditions", conditions, 1, 2**63 - 1, "1 or more")
    as_integer("samples", 1000 if samples is None else samples, 1000, 2**63 - 1, "1000 or more")
    as_integer("seed", seed, 0, 2**64 - 1, "0 to 2**64 - 1")
    # The file is read once, so that the checksum is certainly that of the measured contents.
    contents = read_table(find_table(name_or_path))
    if contents.of_spheres:
        problem, remedy = "is a table of spheres, which is exact", "run: tablegen validate"
        raise InputError("", problem=problem, remedy=remedy, source=str(name_or_path))
    config = stored_config(contents.config, f"{name_or_path}: config")
    _check_agreement(contents, config, str(name_or_path))
    return validate_contents(
        contents,
        config,
        str(name_or_path),
        conditions,
        seed,
        samples=samples,
        accuracy=accuracy,
        at=at,
        progress=progress,
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
    """Validate the contents of a table, as `validate` does for a file.

    ``name`` is the name of the table in the result. `tablegen.tables.generate.generate` calls this
    function too, so that both judge in the same way.
    """
    asked = asked_accuracy(config.accuracy, accuracy)
    asked_spin = asked_accuracy(config.spin_targets, accuracy)
    stored = worst_stored(contents.datasets)
    stored_spin = worst_stored(contents.datasets, "spin_accuracy")
    table = Table(contents)
    places, own = pick_conditions(table, conditions, seed), list[ComparedCondition]()
    if at is not None:
        places = check_conditions(table, [ComparedCondition(*place) for place in at])
    elif table.has_spin:
        own = pick_own_conditions(table, conditions, seed)
    return Validation(
        table=name,
        content_sha256=contents.content_sha256,
        seed=seed,
        config=config,
        asked=asked,
        asked_spin=asked_spin,
        stored=stored | {SPIN + name: value for name, value in stored_spin.items()},
        comparisons=measure(
            table,
            config,
            places,
            seed=seed,
            samples=samples or sample_size(asked),
            progress=progress,
        ),
        own=measure(
            table,
            config,
            own,
            seed=seed,
            samples=samples or sample_size(asked_spin),
            progress=progress,
        ),
        hits=measure_chains(table, config, seed=seed, samples=samples, progress=progress)
        if own
        else [],
    )


def _check_agreement(contents: TableContents, config: Config, origin: str) -> None:
    """Raise `InputError` if a table does not agree with its own configuration."""

    def span(axis: str) -> str:
        return " to ".join(f"{end:.9g}" for end in contents[f"axes/{axis}"][[0, -1]].tolist())

    domain, speeds = config.domain, "{:.9g} to {:.9g}".format(*config.domain.speed)
    if contents.speed_independent:
        speeds = span("speed")
    for field, got, allowed in (
        ("pair", contents.pair, config.pair_name),
        ("axes/alpha_deg", span("alpha_deg"), "{:.9g} to {:.9g}".format(*domain.alpha_deg)),
        ("axes/speed", span("speed"), speeds),
        ("variables", " ".join(contents.variables), " ".join(domain.columns)),
        ("spin law", "one" if contents.has_spin else "none", "one" if config.spin else "none"),
    ):
        if got != allowed:
            allowed += ", as in the configuration of the table"
            raise InputError(field, got, allowed, source=origin)
