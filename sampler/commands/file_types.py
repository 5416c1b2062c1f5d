"""Files that a command is given: those it reads, those it writes, and none that it does both to."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from sampler.errors import InputError
from sampler.files import available, check_output, find_file
from sampler.files.regular import is_one_of

#: File descriptors of what a program prints and is given.
_STREAMS: tuple[tuple[str, str | Path | int], ...] = (
    ("standard input", 0),
    ("standard output", 1),
    ("standard error", 2),
)


class FileType(click.ParamType):
    """Argument or option that stands for files."""

    name = "file"
    written = False

    def files(self, value: Any) -> Iterable[str | Path]:
        """Files that a value, converted before, stands for."""
        return (value,)


class OutputFile(FileType):
    """File that can be written, checked before any work is done."""

    written = True

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Check that there is a regular file or none, in a folder that can be written."""
        try:
            return check_output(value)
        except InputError as error:
            self.fail(str(error).removeprefix("output: "), param, ctx)


class InputFile(FileType):
    """File to be read; whether it can be is for the command to find out."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Take the path."""
        return Path(value)


class Named(FileType):
    """Name of a file that comes with the package, or a path; a shell completes both.

    Whether there is such a file is for the command to find out.

    Parameters
    ----------
    suffix : str
        Of the file.
    files_of : callable, optional
        Gives all files that one of a name or path is read from; by default that file.
    """

    name = "text"

    def __init__(
        self, suffix: str, files_of: Callable[[str], Iterable[str | Path]] | None = None
    ) -> None:
        self.suffix, self._files_of = suffix, files_of

    def files(self, value: str) -> Iterable[str | Path]:
        """Find the file of a name or path; none if there is none."""
        if self._files_of:
            return self._files_of(value)
        try:
            return (find_file("", value, self.suffix),)
        except InputError:
            return ()

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Names that begin with the word, and the files of the shell."""
        names = [name for name in available(self.suffix) if name.startswith(incomplete)]
        return [*map(CompletionItem, names), CompletionItem(incomplete, type="file")]


def check_apart(ctx: click.Context) -> None:
    """Refuse an output that is an input, another output or where the program itself prints to.

    Raises
    ------
    InputError
        Names both.
    """
    others = [*_STREAMS, *_files(ctx, written=False)]
    for flag, path in _files(ctx, written=True):
        for name, other in others:
            if is_one_of(path, (other,)):
                raise InputError(f"{flag}: got {path}, the same file as {name}, allowed: another")
        others.append((flag, path))


def _files(ctx: click.Context, written: bool) -> Iterator[tuple[str, str | Path | int]]:
    """Files that the command was given, each with the name of its flag or argument."""
    for param in ctx.command.params:
        kind, value = param.type, ctx.params.get(str(param.name))
        if isinstance(kind, FileType) and kind.written == written and value is not None:
            for one in value if param.multiple else (value,):
                yield from ((param.opts[0], path) for path in kind.files(one))
