"""The main job in one go: generate a small table, draw from it, validate it, show it."""

import math
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import sampler
from sampler.errors import InputError
from sampler.files.atomic import check_output, write_bytes
from tablegen.accuracy.accuracy_text import accuracy_text, details_text
from tablegen.accuracy.validate import Validation, validate
from tablegen.accuracy.verdict import verdict_words
from tablegen.config.config import Config, load_config
from tablegen.evidence.plots import Source, joint_picture
from tablegen.model.float_array import FloatArray
from tablegen.presentation import require_matplotlib
from tablegen.simulation.simulate import simulate
from tablegen.tables.generate import generate

#: Condition of the example draw, inside the demo scene and at none of its nodes.
_ALPHA_DEG, _SPEED = 35.0, 130.0

#: Conditions of the demo's validation, and those measured while generating.
_CONDITIONS = 6
_MEASURED = 2

#: Timed runs of the draw and of the simulation.
_REPEATS = 5

#: Seed of the validation: the demonstration says the same each time.
_SEED = 1


def run_demo(output: Path, say: Callable[[str], None], progress: bool = True) -> Validation:
    """Generate, draw, validate; say what is done and how good it is.

    Parameters
    ----------
    output : Path
        Where the table is left. Beside it goes a picture of the same name, if matplotlib is there.
    say : callable
        Receives each piece of text.
    progress : bool
        Show progress bars on standard error.

    Returns
    -------
    Validation
    """
    check_output(_picture_path(output))
    config = load_config("demo")
    begin = time.perf_counter()
    alpha, speed = config.domain.alpha_deg, config.domain.speed
    say(
        f"1. Generating {output}: {config.pair.particle} on {config.pair.wall}, "
        f"{alpha[0]:g} to {alpha[1]:g} degrees, {speed[0]:g} to {speed[1]:g} m/s"
    )
    generate(config, output, conditions=_MEASURED, progress=progress)
    say(f"   {output.stat().st_size / 1e3:.0f} kB in {time.perf_counter() - begin:.0f} s")
    direct, drawn, text = _draw_both(config, output)
    say(text)
    say(_picture_text(direct, drawn, output))
    say("3. Validating against fresh direct simulation, at all nodes and between them")
    result = validate(output, conditions=_CONDITIONS, seed=_SEED, progress=progress)
    say(accuracy_text(result.measured, result.declared))
    say(details_text(max(result.comparisons, key=lambda c: c.estimates["auc"].value)))
    for line in (*result.missed, *result.undecided):
        say(line)
    say(verdict_words(result.missed, result.undecided, "declared accuracy"))
    say(f"The table is in {output}; the demo took {time.perf_counter() - begin:.0f} s.")
    return result


def _draw_both(config: Config, output: Path) -> tuple[FloatArray, FloatArray, str]:
    """Simulate and draw at one condition, and say how much faster the draw is."""
    table = sampler.load(output)
    alpha1 = math.radians(_ALPHA_DEG)
    count, simulated, timed = 1_000_000, 100_000, 20_000
    state, index = np.empty((count, len(table.columns))), np.arange(count)
    rebounds = simulate(config, alpha1, _SPEED, simulated, seed=1)
    draw = _median_seconds(
        lambda: table.sample(alpha1, _SPEED, seed=1, index=index, threads=1, out=state)
    )
    direct = _median_seconds(lambda: simulate(config, alpha1, _SPEED, timed, seed=1, threads=1))
    draw, direct = draw / count, direct / timed
    energy = (state[:, :3] ** 2).sum(axis=1)
    text = (
        f"2. Drawing {count:,} rebounds at {_ALPHA_DEG:g} degrees and {_SPEED:g} m/s\n"
        f"   mean u {state[:, 0].mean():.4f}, v {state[:, 1].mean():.4f}, "
        f"omega_z {state[:, 5].mean():.4f}; translational energy {energy.mean():.4f}\n"
        f"   one thread, median of {_REPEATS} runs: {draw * 1e9:.0f} ns a draw, "
        f"{direct * 1e9:.0f} ns a simulated rebound: {direct / draw:.0f} times faster"
    )
    return rebounds.state, state[:simulated], text


def _median_seconds(work: Callable[[], object]) -> float:
    """Median processor time of a piece of work, after a first run that is not counted.

    The first compiles, and meets cold caches and memory that the system has not given yet.
    """
    work()
    seconds = []
    for _ in range(_REPEATS):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds)


def _picture_path(table: Path) -> Path:
    path = table.with_suffix(".png")
    return table.with_name(f"{table.name}.png") if path == table else path


def _picture_text(direct: FloatArray, drawn: FloatArray, table: Path) -> str:
    """Draw the joint density from both sources; where the picture is, or what it needs."""
    try:
        require_matplotlib("picture")
    except InputError as error:
        return f"   no {error}"
    path = _picture_path(table)
    picture = joint_picture(
        [Source("direct simulation", direct), Source("table", drawn)],
        path.name,
        f"Rebound velocities at {_ALPHA_DEG:g}° and {_SPEED:g} m/s",
        "Joint density of the velocities along and normal to the wall: two panels that look alike.",
    )
    write_bytes(path, picture.data)
    return f"   {path}: joint density of u and v, direct simulation beside the table"
