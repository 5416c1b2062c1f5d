"""Coulomb friction of any strength: random impacts of the whole population, each checked."""

from dataclasses import dataclass

import numpy as np

from sampler.errors import OK
from sampler.library import Rows, processors
from tablegen.config.config import Config
from tablegen.evidence.checked import Checked
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


@dataclass(frozen=True, kw_only=True)
class FrictionOutcome(Checked):
    """Rebounds under one law, at 0.5 to 90 degrees and 5 to 300 m/s, half with up to 2 V/a."""

    static: float
    dynamic: float
    restitution: float | None
    most_collisions: int

    def __str__(self) -> str:
        e = "the pair's restitution" if self.restitution is None else f"e = {self.restitution:g}"
        return f"Coulomb {self.static:g}, {self.dynamic:g}, {e}"


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

    def work(part: slice) -> FloatArray:
        index = np.arange(part.start, part.stop, dtype=np.uint64)
        arrays = {"alpha1": alpha[part], "speed": speed[part], "spin": spin[part], "index": index}
        rows = Rows(index.size, seed, arrays | {"hit": np.zeros(1, np.uint32)}, fresh=True)
        run = simulate_impacts(model, rows, threads=1)
        kept = np.square(run.variables[:, :3]).sum(axis=1) / run.energy_before
        kept += run.variables[:, 6]
        return np.column_stack([run.codes, kept, run.variables[:, 1], run.variables[:, 7]])

    parts = [part for _, part in in_slices(work, count, threads)]
    codes, kept, velocity, collisions = np.concatenate(parts).T
    ended = codes >= OK
    return FrictionOutcome(
        static=static,
        dynamic=dynamic,
        restitution=e,
        seed=seed,
        rebounds=count,
        unfinished=int(np.count_nonzero(~ended)),
        growth=float(kept[ended].max()) - 1.0 if ended.any() else None,
        least_velocity=float(velocity[ended].min()) if ended.any() else None,
        most_collisions=int(collisions[ended].max(initial=0)),
    )
