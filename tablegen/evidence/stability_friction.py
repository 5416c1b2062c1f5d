"""Coulomb friction of any strength: random impacts of the whole population, each checked."""

import time
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from sampler.errors import OK
from sampler.library import Rows, processors
from tablegen.config.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.parallel import in_slices
from tablegen.progress import bar
from tablegen.simulation.direct_law import DirectLaw, simulate_impacts

#: Static and dynamic coefficients, and restitutions; None is the pair's own law.
COEFFICIENTS = (
    *((mu, mu) for mu in (0.1, 0.3, 0.6, 1.0, 1.5, 3.0, 10.0, 100.0)),
    (0.6, 0.3),
    (1.5, 1.0),
    (100.0, 10.0),
)
RESTITUTIONS = (0.0, 0.5, 1.0, None)

#: Energy that a rebound may gain, over that before.
MOST_GAIN = 1e-9


def failures_of(growth: float | None, most: float, velocity: float | None) -> dict[str, str]:
    """Describe a gain of energy and a least v+ [V] that are failures; None is no failure."""
    failures = {}
    if growth is not None and growth > most:
        failures["growing energy"] = f"energy grows by {growth:.3g}, and may grow by {most:g}"
    if velocity is not None and velocity <= 0.0:
        failures["not leaving"] = f"a particle leaves with v+ = {velocity:.3g} V, not above 0"
    return failures


@dataclass(frozen=True)
class FrictionOutcome:
    """Rebounds under one law, at 0.5 to 90 degrees and 5 to 300 m/s, half with up to 2 V/a."""

    static: float
    dynamic: float
    restitution: float | None
    #: Of the conditions and the particles, whose indices are the rows.
    seed: int
    rebounds: int
    #: First row that is not finite or is still in contact at the alarm, or -1.
    unfinished: int
    #: Largest gain of energy over that before, smallest v+ [V]; of the other rows.
    growth: float | None
    least_velocity: float | None
    most_collisions: int
    #: Run time of a rebound on one thread [s].
    cost: float = field(compare=False)

    def __str__(self) -> str:
        e = "the pair's restitution" if self.restitution is None else f"e = {self.restitution:g}"
        return f"Coulomb {self.static:g}, {self.dynamic:g}, {e}"

    @property
    def failures(self) -> dict[str, str]:
        """Failures of the model by kind, a line each."""
        failures = {}
        if self.unfinished >= 0:
            failures["unfinished"] = f"particle {self.unfinished} is unfinished"
        return failures | failures_of(self.growth, MOST_GAIN, self.least_velocity)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return {**asdict(self), "failures": list(self.failures.values())}


def run_friction(
    config: Config,
    count: int,
    seed: int = 1,
    threads: int | None = None,
    progress: bool = False,
) -> tuple[FrictionOutcome, ...]:
    """Rebound ``count`` particles of the population under each Coulomb law."""
    laws = [(*pair, e) for pair in COEFFICIENTS for e in RESTITUTIONS]
    outcomes = []
    with bar(progress, "law", total=len(laws), desc="Coulomb friction") as counted:
        for number, law in enumerate(laws):
            one = (seed + number) % 2**64
            outcomes.append(_run_law(config, law, count, one, threads or processors()))
            counted.update()
    return tuple(outcomes)


def _run_law(
    config: Config, law: tuple[float, float, float | None], count: int, seed: int, threads: int
) -> FrictionOutcome:
    """Rebound particles at random conditions under one law, and check each."""
    static, dynamic, e = law
    source = {"source": "stability study"}
    changes = {"resistance": source | {"law": "coulomb", "static": static, "dynamic": dynamic}}
    if e is not None:
        changes["restitution"] = source | {"law": "constant", "value": e}
    # a study of the numerics: speeds at which a law was measured do not matter
    changed = config.with_changes({"pair": changes, "domain": {"extrapolate": True}})
    model = DirectLaw.from_config(changed)
    rng = np.random.default_rng(seed)
    alpha, speed = np.radians(rng.uniform(0.5, 90.0, count)), rng.uniform(5.0, 300.0, count)
    spin = rng.standard_normal((count, 3))
    spin *= (rng.uniform(-2.0, 2.0, count).clip(0.0) / np.linalg.norm(spin, axis=1))[:, None]

    def work(part: slice) -> tuple[FloatArray, float]:
        begin, index = time.perf_counter(), np.arange(part.start, part.stop, dtype=np.uint64)
        arrays = {"alpha1": alpha[part], "speed": speed[part], "spin": spin[part], "index": index}
        rows = Rows(index.size, seed, arrays | {"hit": np.zeros(1, np.uint32)}, fresh=True)
        run = simulate_impacts(model, rows, threads=1)
        kept = np.square(run.variables[:, :3]).sum(axis=1) / run.energy_before
        kept += run.variables[:, 6]
        columns = run.codes, kept, run.variables[:, 1], run.variables[:, 7]
        return np.column_stack(columns), time.perf_counter() - begin

    parts, seconds = zip(*(result for _, result in in_slices(work, count, threads)), strict=True)
    codes, kept, velocity, collisions = np.concatenate(parts).T
    ended = codes >= OK
    return FrictionOutcome(
        *law,
        seed=seed,
        rebounds=count,
        unfinished=-1 if ended.all() else int((~ended).argmax()),
        growth=float(kept[ended].max()) - 1.0 if ended.any() else None,
        least_velocity=float(velocity[ended].min()) if ended.any() else None,
        most_collisions=int(collisions[ended].max(initial=0)),
        cost=sum(seconds) / count,
    )
