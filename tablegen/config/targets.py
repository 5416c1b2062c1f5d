"""The accuracy that a table declares, with and without spin before the impact."""

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field, create_model, model_validator

from tablegen.config.field_types import Record
from tablegen.config.metric_table import (
    JOINT,
    JOINT_METRICS,
    LATER,
    METRICS,
    PRESETS,
    SPIN_PRESETS,
    declared_accuracy,
    metric_of,
)


def _fields_of(limits: dict[str, str]) -> dict[str, Any]:
    """Return the preset, and a field for each limit, given as {limit: metric}."""
    fields: dict[str, Any] = {"preset": (Literal[tuple(PRESETS)], "standard")}
    for limit, metric in limits.items():
        fields[limit] = (Annotated[float, Field(**metric_of(metric).allowed)], ...)
    return fields


_LIMITS = {name: name for name in METRICS}
_SPIN_LIMITS = _LIMITS | {f"{JOINT}{name}": name for name in JOINT_METRICS}
_SPIN_LIMITS |= {name: name for name in LATER}
_Accuracy: Any = create_model("_Accuracy", __base__=Record, **_fields_of(_LIMITS))
_SpinAccuracy: Any = create_model("_SpinAccuracy", __base__=Record, **_fields_of(_SPIN_LIMITS))


class AccuracyTargets(_Accuracy):
    """Largest distances from direct simulation that a table declares, by metric.

    A distance that is not given is the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given) if isinstance(given, dict) else given


class JointTargets(NamedTuple):
    """Largest distances of the law of condition and outcome over the impacts of chains."""

    ks: float
    auc: float


class SpinTargets(_SpinAccuracy):
    """Largest distances from direct simulation that a spin law declares.

    Limits named as a metric hold for particles that do not spin, those with ``joint_`` for the law
    of condition and outcome over the impacts of chains, those with ``cell_`` in cells of
    conditions, and those with ``chain_`` after each hit of chains. A distance that is not given is
    the preset's.
    """

    @model_validator(mode="before")
    @classmethod
    def _from_preset(cls, given: object) -> object:
        return declared_accuracy(given, SPIN_PRESETS) if isinstance(given, dict) else given

    @property
    def joint(self) -> JointTargets:
        """Limits over the impacts of chains."""
        return JointTargets(self.joint_ks, self.joint_auc)
