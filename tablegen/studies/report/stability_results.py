"""The stability study in a report: run briefly, or read from what ``tablegen stability`` wrote."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sampler.errors import InputError
from tablegen.config import Config
from tablegen.studies.stability.cases import QUICK, Case, Grid
from tablegen.studies.stability.outcome import Change, Figures, Outcome
from tablegen.studies.stability.stability_study import Study, run_study

#: What a quick report leaves of the quick study: one third of the angles, one speed.
_BRIEF = Grid((), (), (0.01, 20.0, 90.0), (200.0,), ())


def _change(data: Mapping[str, float] | None) -> Change | None:
    return None if data is None else Change(**data)


def _figures(data: Mapping[str, Any] | None) -> Figures | None:
    if data is None:
        return None
    changes = {name: _change(data[name]) for name in ("contact", "flight")}
    return Figures(**{**data, **changes})


def _outcome(data: Mapping[str, Any]) -> Outcome:
    case = {name: data[name] for name in Case.__dataclass_fields__}
    case["aspect"] = tuple(case["aspect"])
    rest = {
        name: data[name] for name in Outcome.__dataclass_fields__ if name not in ("case", "figures")
    }
    return Outcome(case=Case(**case), figures=_figures(data["figures"]), **rest)


def read_study(path: Path) -> Study:
    """Read a study from the JSON that ``tablegen stability --json`` wrote.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Study

    Raises
    ------
    InputError
        If the file cannot be read, or is something else.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        names = ("pair", "contact_resolution", "tolerance", "seed", "count")
        return Study(
            **{name: data[name] for name in names},
            outcomes=tuple(_outcome(case) for case in data["cases"]),
        )
    except OSError as error:
        raise InputError(f"--stability: {path} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
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

    Returns
    -------
    Study
    """
    grid = QUICK.narrowed(_BRIEF) if quick else QUICK
    return run_study(config, list(grid.cases()), seed=seed, progress=progress)
