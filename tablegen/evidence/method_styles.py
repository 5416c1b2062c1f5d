"""How each method of the comparison is drawn, on the report's page and in the README's picture."""

from typing import NamedTuple


class Look(NamedTuple):
    """Colour and symbol of a method; the symbol says again what the colour says."""

    #: Okabe and Ito's. The dark page turns lightness around and leaves the hue.
    colour: str
    #: Name of the symbol in plotly.
    symbol: str
    #: The same symbol in matplotlib.
    marker: str


#: Methods by family, in the order of a legend.
LOOKS = {
    "table": Look("#0072b2", "circle", "o"),
    "direct simulation": Look("#000000", "square", "s"),
    "stored states": Look("#d55e00", "triangle-up", "^"),
    "independent marginals": Look("#cc79a7", "triangle-down", "v"),
    "Gaussian mixture": Look("#009e73", "diamond", "D"),
    "kernel resampling": Look("#56b4e9", "cross", "P"),
    "vine copula": Look("#e69f00", "x", "X"),
}
