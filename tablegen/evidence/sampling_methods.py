"""Methods of sampling rebound states: what each needs beforehand, holds in memory, and draws."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tablegen.config.config import Config
from tablegen.evidence.method_errors import Draw
from tablegen.model.float_array import FloatArray

#: What a method covers once it is fitted.
DOMAIN, CONDITION = "domain", "condition"


@dataclass(frozen=True)
class BenchmarkCase:
    """A condition at which methods are compared, and direct states to fit them to."""

    config: Config
    alpha_deg: float
    speed: float
    #: Shape (n, 6). Independent of the reference.
    training: FloatArray
    seed: int


@dataclass(frozen=True)
class FittedMethod:
    """A method that is ready to draw."""

    #: Number of states and seed to (n, 6) states, on one thread.
    draw: Draw
    #: Bytes that the draw reads, 0 for none.
    size: int
    #: Seconds that the fit took, if they are not those of the call that made it.
    setup: float | None = None
    #: Further figures, for the record.
    facts: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SamplingMethod:
    """A method of sampling rebound states."""

    #: Methods that are drawn alike.
    family: str
    name: str
    #: ``DOMAIN``: any angle and speed; ``CONDITION``: the one it was fitted at.
    covers: str
    #: From a `BenchmarkCase` to a `FittedMethod`.
    prepare: Callable[[BenchmarkCase], FittedMethod]
    #: Its differences from others of its family.
    settings: dict[str, Any] = field(default_factory=dict)
