"""One table says how the methods are drawn; page and picture take it."""

from tablegen.evidence.method_styles import LOOKS

from tablegen.evidence import baselines, direct_method, table_sizes

MARKERS = {
    "circle": "o",
    "square": "s",
    "triangle-up": "^",
    "triangle-down": "v",
    "diamond": "D",
    "cross": "P",
    "x": "X",
}


def test_every_method_has_a_look():
    found = (*direct_method.direct_methods(), *baselines.baseline_methods()[0])
    families = {method.family for method in found}
    families |= {table_sizes.FAMILY, "stored states", *baselines._OPTIONAL}
    assert families == set(LOOKS)


def test_no_two_methods_look_alike():
    for attribute in ("colour", "symbol", "marker"):
        assert len({getattr(look, attribute) for look in LOOKS.values()}) == len(LOOKS)
    assert {look.symbol: look.marker for look in LOOKS.values()} == MARKERS
