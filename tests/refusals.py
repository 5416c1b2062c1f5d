"""Check a refusal: one line that begins with a field and says what is allowed or what is wrong."""

import pytest

from sampler import InputError


def refused(field, call, *given, **named):
    """Check that a call is refused because of a field, and return the line."""
    with pytest.raises(InputError) as refusal:
        call(*given, **named)
    error = refusal.value
    line = str(error)
    # the place is data, and begins the line
    place = ": ".join(part for part in (error.source, error.argument) if part)
    assert f"{place}: ".startswith(f"{field}: "), line
    assert line.startswith(f"{place}: "), line
    assert error.problem or (error.given is not None and error.allowed), line
    assert "\n" not in line
    return line
