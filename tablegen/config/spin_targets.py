"""The accuracy that a spin law declares."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, create_model, model_validator

from tablegen.config.field_types import Record
from tablegen.config.metric_table import (
    JOINT,
    JOINT_METRICS,
    METRICS,
    PRESETS,
    SPIN_PRESETS,
)


def _limit(name: str) -> Any:
    return (Annotated[float, Field(**METRICS[name].allowed)], ...)


#: The preset, a field for each metric, and one for each that is taken over the impacts of chains.
_FIELDS: dict[str, Any] = {
    "preset": (Literal[tuple(PRESETS)], "standard"),
    **{name: _limit(name) for name in METRICS},
    **{f"{JOINT}{name}": _limit(name) for name in JOINT_METRICS},
}
_SpinFields: Any = create_model("_SpinFields", __base__=Record, **_FIELDS)


@dataclass(frozen=True)
class JointTargets:
    """Largest distances of the law of condition and outcome over the impacts of chains."""

    ks: float
    auc: float


class SpinTargets(_SpinFields):
    """Largest distances from direct simulation that a spin law declares.

    Those named as a metric hold at any condition; the ``joint_`` ones for the law of condition and
    outcome over the impacts of chains. Those that are not given are the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        # an unknown name is refused with the field, not here
        return declared_spin_accuracy(given) if isinstance(given, dict) else given

    @property
    def joint(self) -> JointTargets:
        """Limits over the impacts of chains."""
        return JointTargets(**{name: getattr(self, f"{JOINT}{name}") for name in JOINT_METRICS})


def declared_spin_accuracy(given: Mapping[str, Any]) -> dict[str, Any]:
    """Largest distances that ``[spin_accuracy]`` of a configuration declares.

    Parameters
    ----------
    given : mapping
        The section as it stands in the file.

    Returns
    -------
    dict
        Its fields, and a number for each that it leaves out; unchecked.
    """
    preset = SPIN_PRESETS.get(str(given.get("preset", "standard")), SPIN_PRESETS["standard"])
    return {**preset, **given}
