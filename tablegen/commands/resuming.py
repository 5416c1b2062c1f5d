"""What an interrupted command says of its finished pieces."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import click


@contextmanager
def resumable(output: Path) -> Iterator[None]:
    """Name ``--resume`` when the work in the block is interrupted and has left pieces.

    Parameters
    ----------
    output : Path
        What the work makes; its pieces lie beside it.

    Raises
    ------
    click.Abort
        In place of a `KeyboardInterrupt`, if there are pieces.
    """
    from tablegen.tasks.parts_folder import parts_path

    try:
        yield
    except KeyboardInterrupt:
        kept = parts_path(output)
        if not kept.exists():
            raise
        raise click.Abort(f"the same command with --resume continues from {kept}") from None
