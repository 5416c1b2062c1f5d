"""Whether an accuracy holds, in words."""

from collections.abc import Sequence


def verdict_words(missed: Sequence[str], undecided: Sequence[str], accuracy: str) -> str:
    """Say in one sentence whether an accuracy holds; every text and page says it with these words.

    Parameters
    ----------
    missed, undecided : sequence of str
        As in `tablegen.accuracy.decision.Verdict`.
    accuracy : str
        Whose it is: "declared accuracy", or "accuracy asked for".
    """
    if missed:
        return f"The {accuracy} is missed:"
    if undecided:
        return f"The {accuracy} is not missed, but the noise leaves open whether it holds:"
    return f"The {accuracy} holds at every condition."
