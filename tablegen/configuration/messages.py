"""One line for a configuration that cannot be used: which field, what was given, what is allowed.

The validation library reports positions, error codes and contexts. Here they are put into words,
from the same field declarations that were violated, so that no bound is written twice.
"""

from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from tablegen.configuration.field_types import MISSING, REFUSED

#: Most problems that one line names; more would not be read.
_MOST = 6

#: Longest piece of a given value that is worth repeating.
_LONGEST = 60

_KINDS: dict[Any, str] = {
    float: "a finite number",
    int: "a whole number",
    bool: "true or false",
    str: "text in quotes",
}


class _Place(NamedTuple):
    """Where an error lies: dotted path, the record it is in, the declaration of the field."""

    path: str
    record: type[BaseModel] | None
    field: FieldInfo | None


def complaint(error: ValidationError, record: type[BaseModel]) -> str:
    """Problems of a failed validation, in one line.

    Parameters
    ----------
    error : ValidationError
    record : type of BaseModel
        The record that was validated.

    Returns
    -------
    str
        "field: got value, allowed: ...", for every problem up to `_MOST`, with semicolons between.
    """
    # Unknown fields first: a misspelt field is also a missing one, and the spelling is the cause.
    problems = sorted(
        error.errors(include_url=False), key=lambda problem: problem["type"] != "extra_forbidden"
    )
    lines = list(dict.fromkeys(_describe(problem, record) for problem in problems))
    others = len(lines) - _MOST
    if others > 0:
        lines[_MOST:] = [f"and {others} more problem{'s' if others > 1 else ''}"]
    return "; ".join(lines)


def shown(value: object) -> str:
    """Write a given value as a user would, short and in one line.

    Parameters
    ----------
    value : object

    Returns
    -------
    str
    """
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, float):
        text = f"{value:.12g}"
    elif isinstance(value, list | tuple):
        text = f"[{', '.join(shown(item) for item in value)}]"
    else:
        text = repr(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _describe(problem: ErrorDetails, record: type[BaseModel]) -> str:
    """Words for one problem."""
    position = problem["loc"]
    if problem["type"] == "missing" and isinstance(position[-1], int):
        # A list that is too short: speak of the list, not of the item that it lacks.
        problem, position = {**problem, "type": "too_short"}, position[:-1]
    place = _locate(position, record)
    context = problem.get("ctx", {})
    match problem["type"]:
        case "missing":
            return f"{place.path}: missing, allowed: {_allowed(place.field)}"
        case "extra_forbidden":
            names = ", ".join(_fields(place.record)) if place.record else "none"
            return f"{place.path}: unknown field, allowed here: {names}"
        case "union_tag_invalid" | "union_tag_not_found":
            return _describe_tag(problem, place)
    path, given, allowed = place.path, problem["input"], _allowed(place.field)
    if problem["type"] == REFUSED:
        allowed = context["allowed"]
        path = ".".join(part for part in (path, context["field"]) if part)
        given = given if context["given"] is None else context["given"]
        if given is MISSING:
            return f"{path}: missing, allowed: {allowed}"
    elif problem["type"] == "literal_error":
        allowed = context["expected"]
    elif isinstance(position[-1], int):
        allowed = _item_allowed(place.field)
    # A whole number written as 1.0 is refused for its point, which must then be seen.
    got = repr(given) if problem["type"].startswith("int_") else shown(given)
    return f"{path}: got {got}, allowed: {allowed}"


def _describe_tag(problem: ErrorDetails, place: _Place) -> str:
    """Words for a choice (such as a distribution) that is unknown or was not made."""
    key = str(place.field.discriminator) if place.field else ""
    members = _members(place.field)
    tags = ", ".join(repr(tag) for member in members for tag in _tags(member, key))
    given = problem["input"].get(key) if isinstance(problem["input"], dict) else None
    got = "missing" if given is None else f"got {shown(given)}"
    return f"{place.path}.{key}: {got}, allowed: {tags}"


def _fields(record: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of a record under the names that a file uses."""
    return {field.alias or name: field for name, field in record.model_fields.items()}


def _locate(parts: tuple[int | str, ...], record: type[BaseModel]) -> _Place:
    """Follow the library's position through the records to a dotted path."""
    inside: type[BaseModel] | None = record
    field: FieldInfo | None = None
    path = ""
    for part in parts:
        if isinstance(part, int):
            path += f"[{part}]"
            continue
        chosen = _chosen_member(field, part)
        if chosen is not None:
            # The library names the chosen kind in its position; a file has no such level.
            inside, field = chosen, None
            continue
        if field is not None:
            inside = next(iter(_members(field)), None)
        path += f".{part}" if path else part
        field = _fields(inside).get(part) if inside else None
    return _Place(path, inside, field)


def _members(field: FieldInfo | None) -> list[type[BaseModel]]:
    """Record types that a field may hold."""
    if field is None:
        return []
    options = get_args(field.annotation) or (field.annotation,)
    return [kind for kind in options if isinstance(kind, type) and issubclass(kind, BaseModel)]


def _tags(member: type[BaseModel], key: str) -> tuple[str, ...]:
    """Values of the distinguishing field that select a record type."""
    return get_args(member.model_fields[key].annotation)


def _chosen_member(field: FieldInfo | None, tag: str) -> type[BaseModel] | None:
    """Record type that a tag selects, if the field is a choice between several."""
    if field is None or not isinstance(field.discriminator, str):
        return None
    key = field.discriminator
    return next((member for member in _members(field) if tag in _tags(member, key)), None)


def _bare(annotation: Any) -> Any:
    """Annotation without "or None", and without the validators that hang on it."""
    if get_origin(annotation) in (Union, UnionType):
        annotation = next(kind for kind in get_args(annotation) if kind is not type(None))
    return get_args(annotation)[0] if get_origin(annotation) is Annotated else annotation


def _allowed(field: FieldInfo | None) -> str:
    """Put into words what a field takes, from its declaration."""
    if field is None:
        return "a table of fields"
    kind = _bare(field.annotation)
    if _members(field):
        return "a table of fields"
    if get_origin(kind) is tuple:
        items = get_args(kind)
        return "a list of numbers" if Ellipsis in items else f"a list of {len(items)} numbers"
    if kind in _KINDS:
        return _KINDS[kind] + _bounds(field.metadata)
    return " or ".join(repr(option) for option in get_args(kind))


def _item_allowed(field: FieldInfo | None) -> str:
    """Put into words what an item of a list takes."""
    item = get_args(_bare(field.annotation))[0] if field else float
    declared = getattr(item, "__metadata__", ())
    return _KINDS[float] + _bounds([part for info in declared for part in info.metadata])


def _bounds(metadata: list[Any]) -> str:
    """Interval that the declared bounds leave, with a leading space; empty if there are none."""
    words = []
    for attribute, word in (("gt", "above"), ("ge", "at least"), ("lt", "below"), ("le", "up to")):
        for part in metadata:
            bound = getattr(part, attribute, None)
            if bound is not None:
                words.append(f"{word} {shown(bound)}")
    return f" {' and '.join(words)}" if words else ""
