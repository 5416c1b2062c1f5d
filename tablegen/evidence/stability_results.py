"""The stability study in a report: run briefly, or read from what ``tablegen stability`` wrote."""

import json
from pathlib import Path

from pydantic import TypeAdapter

from sampler.errors import InputError
from sampler.files import read_file
from tablegen.config.config import Config
from tablegen.evidence.cases import QUICK, Grid
from tablegen.evidence.stability_study import Study, run_study

#: What a quick report leaves of the quick study: one third of the angles, one speed.
_BRIEF = Grid((), (), (0.01, 20.0, 90.0), (200.0,), ())


def read_study(path: Path) -> Study:
    """Read a study from the JSON that ``tablegen stability --json`` wrote.

    Raises
    ------
    InputError
        If the file cannot be read, or is something else.
    """
    text = read_file("--stability", path)
    try:
        data = json.loads(text)
        # a case is written among what was measured of it
        outcomes = [{**outcome, "case": outcome} for outcome in data["cases"]]
        return TypeAdapter(Study).validate_python({**data, "outcomes": outcomes})
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"--stability: got {path}, allowed: a file that 'tablegen stability --json' wrote"
        ) from error


def brief_study(config: Config, quick: bool, seed: int, progress: bool) -> Study:
    """Run the quick stability study, or a part of it.

    Parameters
    ----------
    config : Config
    quick : bool
        Only a part.
    seed : int
    progress : bool
        Show a progress bar on standard error.
    """
    grid = QUICK.narrowed(_BRIEF) if quick else QUICK
    return run_study(config, list(grid.cases()), seed=seed, progress=progress)
