"""The mistakes in a configuration: field, what was given, what is allowed."""

from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails, PydanticCustomError

from sampler.errors import InputError, shortened

#: What is allowed, by the type of pydantic's error, whose context fills the places.
_ALLOWED = {
    "greater_than": "above {gt:g}",
    "greater_than_equal": "{ge:g} or more",
    "less_than": "below {lt:g}",
    "less_than_equal": "at most {le:g}",
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "an integer",
    "int_from_float": "an integer",
    "bool_type": "true or false",
    "string_type": "a text",
    "literal_error": "{expected}",
    "too_short": "at least {min_length} items",
    "too_long": "at most {max_length} items",
    "tuple_type": "a list, [ ... ]",
    "list_type": "a list, [ ... ]",
    "dict_type": "a table, [...]",
    "model_type": "a table, [...]",
    "model_attributes_type": "a table, [...]",
    "value_error": "{error}",
    "missing": "a value",
}

#: Error type of `refusal`.
_REFUSED = "refused"

#: Value of a field that is not in the file, for `refusal`.
MISSING = object()


def refusal(field: str, given: object, allowed: str) -> PydanticCustomError:
    """Make the error for a field that contradicts another; a validator raises it.

    `field` is the dotted path relative to the validated record. A rule about one field alone
    raises a ValueError that says what is allowed.
    """
    # Braces would be read as placeholders of the template, so the text travels as context.
    context = {"allowed": allowed, "given": given, "field": field}
    return PydanticCustomError(_REFUSED, "{allowed}", context)


def complaint(error: ValidationError, record: type[BaseModel], prefix: str = "") -> InputError:
    """Make one error of all mistakes that the validation of a record found.

    Unknown fields come first: a misspelt field is also a missing one. `prefix` begins the name of
    each field.
    """
    problems = error.errors(include_url=False)
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")
    mistakes = {each.argument: each for each in (_mistake(one, record) for one in problems)}
    first, *further = (
        each.replaced(argument=f"{prefix}{each.argument}") for each in mistakes.values()
    )
    return first.replaced(further=tuple(further))


def shown(value: object) -> str:
    """Write a value as a file has it, shortened, on one line."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.9g}"
    if isinstance(value, list | tuple):
        return shortened(f"[{', '.join(shown(item) for item in value)}]")
    return shortened(repr(value))


def _mistake(problem: ErrorDetails, record: type[BaseModel]) -> InputError:
    """Make the error of one mistake."""
    kind, given, context = problem["type"], problem["input"], problem.get("ctx", {})
    path, around, inside = _place(problem["loc"], record)
    if kind == "extra_forbidden":
        return InputError(path, problem="unknown field", allowed=", ".join(_fields(around)))
    if kind == _REFUSED:
        path = ".".join(part for part in (path, context["field"]) if part)
        given, allowed = context["given"], context["allowed"]
    elif kind.startswith("union_tag"):
        key = context["discriminator"].strip("'")
        path, given = f"{path}.{key}", given.get(key, MISSING)
        allowed = ", ".join(repr(tag) for member in inside for tag in _tags(member))
    else:
        allowed = _ALLOWED[kind].format(**context) if kind in _ALLOWED else problem["msg"]
    if kind == "missing" or given is MISSING:
        return InputError(path, problem="is missing", allowed=allowed)
    # The point in 1.0 is what is wrong where an integer belongs.
    text = repr(given) if kind.startswith("int_") and isinstance(given, float) else shown(given)
    return InputError(path, text, allowed)


def _place(
    position: tuple[int | str, ...], record: type[BaseModel]
) -> tuple[str, type[BaseModel], list[type[BaseModel]]]:
    """Return a position's dotted path, the record around it, and the records it may hold."""
    path, around, inside = "", record, [record]
    for part in position:
        tagged = [member for member in inside if part in _tags(member)]
        if isinstance(part, int):
            path += f"[{part}]"
        elif tagged:
            # pydantic's positions contain the chosen law; a file has no such level
            inside = tagged
        else:
            path += f".{part}" if path else part
            around = inside[0]
            inside = _records(_fields(around).get(part))
    return path, around, inside


def _fields(record: type[BaseModel]) -> dict[str, Any]:
    """Return the types of a record's fields by their names in a file."""
    return {field.alias or name: field.annotation for name, field in record.model_fields.items()}


def _records(annotation: Any) -> list[type[BaseModel]]:
    """Return the record types that a type mentions."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [record for part in get_args(annotation) for record in _records(part)]


def _tags(member: type[BaseModel]) -> list[str]:
    """Return the words that select a record type: its ``law`` or ``distribution``."""
    kinds = [field.annotation for field in member.model_fields.values()]
    return [tag for kind in kinds if get_origin(kind) is Literal for tag in get_args(kind)]
