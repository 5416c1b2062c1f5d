"""Choices and defaults that the command line shares with the library.

They lie here, where nothing is imported, so that a help page need not load what does the work.
"""

from collections.abc import Mapping
from typing import Any

#: Name of the non-spherical shapes together, with the weights of the population.
MIXTURE = "mixture"

#: Conditions at which a new table is measured, and those of a validation.
GENERATE_CONDITIONS = 8
VALIDATE_CONDITIONS = 8

#: Particles of a case of the stability study.
STABILITY_COUNT = 16

#: Particles of each shape at each angle of the paper's figures.
FIGURES_COUNT, FIGURES_QUICK_COUNT = 200_000, 20_000

#: Names of the distances between a table and direct simulation.
METRICS = ("ks", "sliced_wasserstein", "correlation_error", "auc")

#: Accuracies by name.
PRESETS: dict[str, dict[str, float]] = {
    "compact": {"ks": 0.04, "sliced_wasserstein": 0.025, "correlation_error": 0.06, "auc": 0.65},
    "standard": {"ks": 0.01, "sliced_wasserstein": 0.008, "correlation_error": 0.02, "auc": 0.56},
    "fine": {"ks": 0.005, "sliced_wasserstein": 0.006, "correlation_error": 0.015, "auc": 0.53},
}


def declared_accuracy(given: Mapping[str, Any]) -> dict[str, Any]:
    """Largest distances that ``[accuracy]`` of a configuration declares, by number or preset.

    Parameters
    ----------
    given : mapping
        The section as it stands in the file.

    Returns
    -------
    dict
        Its fields, and a number for each of `METRICS`; unchecked.
    """
    preset = PRESETS.get(str(given.get("preset", "standard")), PRESETS["standard"])
    return {**preset, **given}
