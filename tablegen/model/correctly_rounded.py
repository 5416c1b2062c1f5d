"""Cosine and sine with the same bits on every machine.

The C library's differ between processors in the last bit, where it is a close call which of two
numbers is nearer. These are always the nearer one, computed in integer multiples of 2^-200.
"""

_BITS = 200
_ONE = 1 << _BITS


def _series(term: int, square: int, n: int) -> int:
    """Sum of a series whose term shrinks by -x^2 / (n + 1) / (n + 2), then with n + 2."""
    total = 0
    while term:
        total += term
        term = (-term * square >> _BITS) // ((n + 1) * (n + 2))
        n += 2
    return total


def cosine_and_sine(angle: float) -> tuple[float, float]:
    """Cosine and sine, correctly rounded.

    Parameters
    ----------
    angle : float
        From 0 to 2 [rad].

    Returns
    -------
    tuple of two floats
    """
    if angle < 2.0**-27:  # what is left out is below half a unit in the last place
        return 1.0, angle
    above, below = angle.as_integer_ratio()
    x = (above << _BITS) // below
    square = x * x >> _BITS
    # the quotient of two integers is rounded correctly by Python
    return _series(_ONE, square, 0) / _ONE, _series(x, square, 1) / _ONE
