"""Numbers in messages: a refused one must not look like the limit that it lies beyond."""


def told_apart(value: float, *limits: float, digits: int = 9) -> str:
    """Text of a value with so many digits, or as many more as tell it from the limits.

    Parameters
    ----------
    value : float
    limits : float
        What the message names beside it; one that equals the value does not count.
    digits : int
        Significant digits, where these do.
    """
    others = [limit for limit in limits if limit != value]
    for count in range(digits, 18):
        text = f"{value:.{count}g}"
        if text not in (f"{limit:.{count}g}" for limit in others):
            break
    return text
