"""TOML text to a tree that is safe to walk, check and print."""

import tomllib
from collections.abc import Iterator

from sampler.errors import InputError
from sampler.formats.bounds import is_line, is_text
from tablegen.config.scenes import Tree

#: Deepest nesting of tables and lists; the coordinates of a mesh are the deepest of a
#: configuration, on level 6.
MOST_LEVELS = 20

#: Longest key, in characters.
_KEY_CHARACTERS = 100

#: Integers are below this in magnitude: beyond all bounds of fields, which say more.
_LARGEST = 10**100

_INTEGERS = "integers of up to 100 digits"
_CHARACTERS = "characters that can be shown on a terminal"


def parse_toml(text: str, origin: str) -> Tree:
    """Read a TOML text.

    Parameters
    ----------
    text : str
    origin : str
        Where the text comes from, to open every error message.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        If it is no TOML, or as `check_tree`.
    """
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{origin}: not valid TOML: {error}") from error
    except RecursionError:
        raise InputError(f"{origin}: {_too_deep()}") from None
    except ValueError as error:  # Python reads integers of up to some thousand digits only
        given = "got an integer of too many digits"
        raise InputError(f"{origin}: {given}, allowed: {_INTEGERS}") from error
    check_tree(tree, origin)
    return tree


def check_tree(tree: Tree, origin: str) -> None:
    """Refuse a tree that is nested deeper than `MOST_LEVELS`, or cannot be checked and shown.

    Parameters
    ----------
    tree : dict
        Nested as in a file; tuples may stand for lists.
    origin : str
        Where it comes from, to open an error message.

    Raises
    ------
    InputError
        Also for integers beyond 10**100, long keys, and keys or texts with characters that control
        a terminal.
    """
    for problem in _problems(tree):
        raise InputError(f"{origin}: {problem}")


def _too_deep() -> str:
    return f"got tables or lists nested in each other, allowed: {MOST_LEVELS} levels"


def _problems(tree: Tree) -> Iterator[str]:
    """Find what is wrong in a tree; without recursion, which has an end of its own."""
    below: list[object] = [tree]
    for _ in range(MOST_LEVELS):
        above, below = below, []
        for part in above:
            if isinstance(part, dict):
                yield from _wrong_keys(part)
                below += part.values()
            elif isinstance(part, list | tuple):
                below += part
            elif isinstance(part, int) and not -_LARGEST < part < _LARGEST:
                yield f"got an integer of {part.bit_length()} bits, allowed: {_INTEGERS}"
            elif isinstance(part, str) and not is_text(part):
                yield f"got the text {part[:_KEY_CHARACTERS]!r}, allowed: {_CHARACTERS}"
    if below:
        yield _too_deep()


def _wrong_keys(table: Tree) -> Iterator[str]:
    for key in map(str, table):
        if not is_line(key) or len(key) > _KEY_CHARACTERS:
            allowed = f"up to {_KEY_CHARACTERS} {_CHARACTERS}"
            yield f"got the key {key[:_KEY_CHARACTERS]!r}, allowed: {allowed}"
