"""Stability study: extreme cases, Coulomb friction of any strength, and chains of hits."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import sampler
from sampler.errors import InputError
from tablegen.config.config import Config
from tablegen.config.defaults import STABILITY_COUNT
from tablegen.evidence.checked import Checked
from tablegen.evidence.stability_cases import Case, CaseOutcome, run_case
from tablegen.evidence.stability_chains import ChainOutcome, run_chains
from tablegen.evidence.stability_friction import FrictionOutcome, run_friction
from tablegen.parallel import in_threads
from tablegen.progress import bar


@dataclass(frozen=True)
class Study:
    """Outcomes of all cases; case k has the seed (seed + k) mod 2**64 and `count` particles."""

    pair: str
    contact_resolution: float
    tolerance: float
    seed: int
    count: int
    outcomes: tuple[CaseOutcome, ...]
    #: Random impacts under Coulomb's law, if they were asked for.
    friction: tuple[FrictionOutcome, ...] = ()
    #: Grains through many hits, if they were asked for.
    chains: tuple[ChainOutcome, ...] = ()

    @property
    def failed(self) -> tuple[Checked, ...]:
        """Outcomes in which the model failed."""
        every: tuple[Checked, ...] = (*self.outcomes, *self.friction, *self.chains)
        return tuple(outcome for outcome in every if outcome.failures)

    @property
    def holds(self) -> bool:
        """Whether the model failed in no case."""
        return not self.failed

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers and names, for JSON: degrees, m/s and s."""
        data = {"software_version": sampler.__version__, **vars(self), "holds": self.holds}
        data["cases"] = data.pop("outcomes")
        for name in ("friction", "chains", "cases"):
            data[name] = [outcome.to_dict() for outcome in data[name]]
        return data


def run_study(
    config: Config,
    cases: Sequence[Case],
    *,
    count: int = STABILITY_COUNT,
    friction: int = 0,
    chained: int = 0,
    seed: int = 1,
    threads: int | None = None,
    progress: bool = False,
) -> Study:
    """Simulate and check cases of ``count`` particles.

    ``friction`` is the number of particles under each law of Coulomb friction
    (`tablegen.evidence.stability_friction`), ``chained`` that of grains of each kind in chains of
    hits (`tablegen.evidence.stability_chains`). Threads change nothing but the run time. Raises
    `InputError` if the tolerance cannot be halved.
    """
    numerics = config.model
    if numerics.tolerance < 2e-14:
        allowed = "2e-14 to 1e-4 in a stability study, which halves it"
        raise InputError("model.tolerance", f"{numerics.tolerance:g}", allowed)
    # a random order mixes cheap and expensive cases, for an even progress
    order = np.random.default_rng(0).permutation(len(cases)).tolist()

    def check(number: int) -> CaseOutcome:
        return run_case(config, cases[number], count, (seed + number) % 2**64)

    with bar(progress, "case", total=len(cases), desc="checking") as counted:
        checked = dict(zip(order, in_threads(check, order, counted.update, threads), strict=True))
    return Study(
        config.pair_name,
        numerics.contact_resolution,
        numerics.tolerance,
        seed,
        count,
        tuple(checked[number] for number in range(len(cases))),
        run_friction(config, friction, seed, threads, progress) if friction else (),
        run_chains(config, chained, seed, progress) if chained else (),
    )
