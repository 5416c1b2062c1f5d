"""All figures with what they show."""

from dataclasses import dataclass

from sampler.table import Table
from tablegen.config import Config


@dataclass(frozen=True)
class Gallery:
    """Figures and statements."""


def make_gallery(
    table: Table, config: Config, count: int, seed: int, progress: bool
) -> Gallery | None:
    """Stub."""
    return None
