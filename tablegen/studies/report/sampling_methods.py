"""Methods of sampling rebound states: what each needs beforehand, holds in memory, and draws."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tablegen.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.studies.report.method_errors import Draw

#: What a method covers once it is fitted.
DOMAIN, CONDITION = "domain", "condition"


@dataclass(frozen=True)
class BenchmarkCase:
    """A condition at which methods are compared, and direct states to fit them to.

    Attributes
    ----------
    config : Config
    alpha_deg, speed : float
    training : float64 array, shape (n, 6)
        Independent of the reference.
    seed : int
    """

    config: Config
    alpha_deg: float
    speed: float
    training: FloatArray
    seed: int


@dataclass(frozen=True)
class FittedMethod:
    """A method that is ready to draw.

    Attributes
    ----------
    draw : callable
        Number of states and seed to (n, 6) states, on one thread.
    size : int
        Bytes that the draw reads, 0 for none.
    setup : float or None
        Seconds that the fit took, if they are not those of the call that made it.
    facts : dict
        Further figures, for the record.
    """

    draw: Draw
    size: int
    setup: float | None = None
    facts: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SamplingMethod:
    """A method of sampling rebound states.

    Attributes
    ----------
    family : str
        Methods that are drawn alike.
    name : str
    covers : str
        ``DOMAIN``: any angle and speed; ``CONDITION``: the one it was fitted at.
    prepare : callable
        From a `BenchmarkCase` to a `FittedMethod`.
    settings : dict
        Its differences from others of its family.
    """

    family: str
    name: str
    covers: str
    prepare: Callable[[BenchmarkCase], FittedMethod]
    settings: dict[str, Any] = field(default_factory=dict)
