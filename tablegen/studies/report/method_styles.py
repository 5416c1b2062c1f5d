"""How each method of the comparison is drawn, on the report's page and in the README's picture."""

from typing import NamedTuple


class Look(NamedTuple):
    """Colour and symbol of a method; the symbol says again what the colour says.

    Attributes
    ----------
    light, dark : str
        Colour on a light and on a dark background. The light ones are Okabe and Ito's.
    symbol : str
        Name of the symbol in plotly.
    marker : str
        The same symbol in matplotlib.
    """

    light: str
    dark: str
    symbol: str
    marker: str


#: Methods by family, in the order of a legend.
LOOKS = {
    "table": Look("#0072b2", "#4a9fe0", "circle", "o"),
    "direct simulation": Look("#000000", "#e9ecef", "square", "s"),
    "stored states": Look("#d55e00", "#ff8a50", "triangle-up", "^"),
    "independent marginals": Look("#cc79a7", "#ea94c0", "triangle-down", "v"),
    "Gaussian mixture": Look("#009e73", "#3cc9a0", "diamond", "D"),
    "kernel resampling": Look("#56b4e9", "#a5dcff", "cross", "P"),
    "vine copula": Look("#e69f00", "#f0b030", "x", "X"),
}
