"""Ways to get a rebound state: what each needs beforehand, holds in memory, and draws."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from tablegen.config import Config
from tablegen.model.float_array import FloatArray
from tablegen.studies.report.method_errors import Draw

#: What a way covers once it is set up.
DOMAIN, CONDITION = "domain", "condition"


@dataclass(frozen=True)
class Scene:
    """A condition at which ways are compared, and direct states to fit them on.

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
class Prepared:
    """A way that is ready to draw.

    Attributes
    ----------
    draw : callable
        Number of states and seed to (n, 6) states, on one thread.
    size : int
        Bytes that the draw reads, 0 for none.
    setup : float or None
        Seconds that the setting-up took, if they are not those of the call that prepared it.
    facts : dict
        Further figures, for the record.
    """

    draw: Draw
    size: int
    setup: float | None = None
    facts: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Way:
    """A way to get a rebound state.

    Attributes
    ----------
    family : str
        Ways that are drawn alike.
    name : str
    covers : str
        ``DOMAIN``: any angle and speed; ``CONDITION``: the one it was fitted at.
    prepare : callable
        From a `Scene` to a `Prepared` way.
    settings : dict
        What tells it from others of its family.
    """

    family: str
    name: str
    covers: str
    prepare: Callable[[Scene], Prepared]
    settings: dict[str, Any] = field(default_factory=dict)
