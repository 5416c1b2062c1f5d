"""What every refusal is: one line that begins with a field and says what is allowed."""

import pytest

from sampler import InputError


def refused(field, call, *given, **named):
    """Check that a call is refused because of a field, and return the line."""
    with pytest.raises(InputError) as refusal:
        call(*given, **named)
    line = str(refusal.value)
    assert line.startswith(f"{field}: "), line
    assert "allowed" in line
    assert "\n" not in line
    return line
