"""Errors that a user can cause, each with one line: what, what was given, what is allowed."""


class InputError(ValueError):
    """An argument, field or flag that cannot be used."""


class TableError(InputError):
    """A table file that cannot be read as a rebound table."""


class OutsideTableWarning(UserWarning):
    """Draws lay outside a table and were moved to its edge; given once a table, at the first."""
