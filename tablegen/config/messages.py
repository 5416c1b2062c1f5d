"""One line for a configuration that cannot be used: which field, what was given, what is allowed.

The bounds stand in the declarations of the fields, and pydantic puts them into words. Here its
positions become the paths that a user reads in the file.
"""

import re
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from sampler.errors import shortened

#: Most problems that one line names; more would not be read.
_MOST = 6

#: What pydantic writes around what is allowed.
_AROUND = re.compile(r"^(Input|Tuple) should (be|have) |^Value error, | after validation.*")

#: Type of the errors of `refusal`.
_REFUSED = "refused"

#: What `refusal` is given for a field that must be there.
MISSING = object()


def refusal(field: str, given: object, allowed: str) -> PydanticCustomError:
    """Error of a field that does not agree with another; raise it where both are known.

    A rule about one field alone raises a ValueError that says what is allowed.

    Parameters
    ----------
    field : str
        Dotted path of the offending field, relative to the validated record.
    given : object
        Its value; `MISSING` for none.
    allowed : str
        What the rule allows, to follow the word "allowed:".

    Returns
    -------
    PydanticCustomError
        To be raised inside a validator.
    """
    # Braces would be read as placeholders of the template, so the text travels as context.
    return PydanticCustomError(
        _REFUSED, "{allowed}", {"allowed": allowed, "given": given, "field": field}
    )


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
    # One line a field: a list that lacks two numbers is one thing to mend.
    lines = list(dict(_described(problem, record) for problem in problems).values())
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
        text = f"{value:.12g}" if float(f"{value:.12g}") == value else repr(value)
    elif isinstance(value, list | tuple):
        text = f"[{', '.join(shown(item) for item in value)}]"
    else:
        text = repr(value)
    return shortened(text)


def _described(problem: ErrorDetails, record: type[BaseModel]) -> tuple[str, str]:
    """Path of the offending field, and the line for it."""
    kind, position, given = problem["type"], problem["loc"], problem["input"]
    context = problem.get("ctx", {})
    allowed = _AROUND.sub("", problem["msg"])
    if kind == "missing" and isinstance(position[-1], int):
        # A list that is too short: speak of the list, not of the item that it lacks.
        kind, allowed, position = "too_short", f"at least {position[-1] + 1} items", position[:-1]
    path, around, inside = _place(position, record)
    if kind == "extra_forbidden":
        return path, f"{path}: unknown field, allowed here: {', '.join(_fields(around))}"
    if kind == _REFUSED:
        path = ".".join(part for part in (path, context["field"]) if part)
        given, allowed = context["given"], context["allowed"]
    elif kind.startswith("union_tag"):
        key = context["discriminator"].strip("'")
        path, given = f"{path}.{key}", given.get(key, MISSING)
        allowed = ", ".join(repr(tag) for member in inside for tag in _tags(member))
    elif kind == "missing":
        given, allowed = MISSING, "a value"
    if given is MISSING:
        return path, f"{path}: missing, allowed: {allowed}"
    # A whole number written as 1.0 is refused for its point, which must then be seen.
    got = shortened(repr(given)) if kind.startswith("int_") else shown(given)
    return path, f"{path}: got {got}, allowed: {allowed}"


def _place(
    position: tuple[int | str, ...], record: type[BaseModel]
) -> tuple[str, type[BaseModel], list[type[BaseModel]]]:
    """Dotted path of a position, the record around it, and those that the field may hold."""
    path, around, inside = "", record, [record]
    for part in position:
        tagged = [member for member in inside if part in _tags(member)]
        if isinstance(part, int):
            path += f"[{part}]"
        elif tagged:
            # pydantic names the chosen kind in its position; a file has no such level
            inside = tagged
        else:
            path += f".{part}" if path else part
            around = inside[0]
            inside = _records(_fields(around).get(part))
    return path, around, inside


def _fields(record: type[BaseModel]) -> dict[str, Any]:
    """Types of the fields of a record, under the names that a file uses."""
    return {field.alias or name: field.annotation for name, field in record.model_fields.items()}


def _records(annotation: Any) -> list[type[BaseModel]]:
    """Record types that a type mentions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [record for part in get_args(annotation) for record in _records(part)]


def _tags(member: type[BaseModel]) -> list[str]:
    """Words that select a record type among several: its law or its distribution."""
    kinds = [field.annotation for field in member.model_fields.values()]
    return [tag for kind in kinds if get_origin(kind) is Literal for tag in get_args(kind)]
