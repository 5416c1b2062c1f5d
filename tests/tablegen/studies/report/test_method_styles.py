"""One table says how the methods are drawn; page and picture take it."""

import re
from importlib import resources

from tablegen.studies.report import baselines as rivals
from tablegen.studies.report import direct_method as direct
from tablegen.studies.report import table_sizes as tables
from tablegen.studies.report.method_styles import LOOKS
from tablegen.studies.report.report_page import plot_data

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
    families = {way.family for way in (*direct.direct_methods(), *rivals.baseline_methods()[0])}
    families |= {tables.FAMILY, "stored states", *rivals._OPTIONAL}
    assert families == set(LOOKS)


def test_no_two_methods_look_alike():
    for attribute in ("light", "dark", "symbol", "marker"):
        assert len({getattr(look, attribute) for look in LOOKS.values()}) == len(LOOKS)
    assert {look.symbol: look.marker for look in LOOKS.values()} == MARKERS


def test_the_page_takes_its_colours_from_there(dossier):
    given = plot_data(dossier)["families"]
    assert list(given) == list(LOOKS)
    for family, look in LOOKS.items():
        assert given[family] == {"light": look.light, "dark": look.dark, "symbol": look.symbol}
    script = (
        resources.files("tablegen.studies.report").joinpath("assets", "page.js").read_text("utf-8")
    )
    assert "data.families" in script
    # and names no other method in passing, but those that plots single out
    named = {family for family in LOOKS if re.search(f'"{family}": *{{', script)}
    assert named == set()
