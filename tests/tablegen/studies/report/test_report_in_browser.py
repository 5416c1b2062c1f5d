"""The page of a report in a real browser: draws, reacts, fits a phone, can be read."""

import time

import pytest
from browser import browser, missing, prefer, requested, resize

from tablegen.studies.report.report_page import report_page

pytest.importorskip("plotly")
pytestmark = pytest.mark.skipif(missing() is not None, reason=str(missing()))

PLOTS = (
    *("plot-map", "marginal-first", "marginal-second", "joint-direct", "joint-table", "joint-gap"),
    *("plot-race", "plot-designs", "plot-sizes", "plot-numerics"),
)

#: Smallest contrast of each text with what is painted behind it (WCAG 2.2, success criterion
#: 1.4.3): ratio less what its size asks for, with the text.
CONTRAST = """
const channel = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const luminance = ([r, g, b]) =>
  0.2126 * channel(r / 255) + 0.7152 * channel(g / 255) + 0.0722 * channel(b / 255);
const parse = (text) => [...text.match(/[\\d.]+/g).map(Number), 1].slice(0, 4);
function behind(element) {
  for (let e = element; e; e = e.parentElement) {
    const colour = parse(getComputedStyle(e).backgroundColor);
    if (colour[3] === 1) return colour;
  }
  return [255, 255, 255, 1];
}
const worst = [];
for (const element of document.querySelectorAll("body *")) {
  const own = [...element.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
  const style = getComputedStyle(element);
  if (!own || !element.getClientRects().length || style.visibility === "hidden") continue;
  const svg = element instanceof SVGElement;
  const front = parse(svg ? style.fill : style.color);
  // labels on the cells of a map choose their colour by the cell
  if (svg && element.closest(".heatmap-label")) continue;
  const [a, b] = [luminance(front), luminance(behind(element))].sort((x, y) => y - x);
  const size = parseFloat(style.fontSize), bold = parseInt(style.fontWeight) >= 700;
  const asked = size >= 24 || (bold && size >= 18.66) ? 3 : 4.5;
  worst.push([(a + 0.05) / (b + 0.05) - asked, element.textContent.slice(0, 40)]);
}
return worst.sort((x, y) => x[0] - y[0]).slice(0, 5).concat([[worst.length, "texts"]]);
"""


@pytest.fixture(scope="module")
def page(dossier, tmp_path_factory):
    """The page, opened and drawn."""
    folder = tmp_path_factory.mktemp("browser")
    file = folder / "report.html"
    file.write_text(report_page(dossier), encoding="utf-8")
    with browser(folder / "profile") as driver:
        resize(driver, 1280)
        prefer(driver, "light")
        driver.get(file.as_uri())
        wait(driver, "return document.documentElement.dataset.ready === 'yes'")
        yield driver


def wait(driver, question, seconds=30.0):
    """Ask until the answer is true."""
    end = time.monotonic() + seconds
    while not driver.execute_script(question):
        assert time.monotonic() < end, question
        time.sleep(0.05)


def complaints(driver):
    """What the console says that is not mere information."""
    entries = driver.get_log("browser")
    return [e["message"] for e in entries if e["level"] in ("SEVERE", "WARNING")]


def label(driver, identity):
    return driver.execute_script(
        f"return document.getElementById('{identity}').getAttribute('aria-label')"
    )


def marks(driver, identity):
    """Everything that a plot shows, as text."""
    return driver.execute_script(
        f"return JSON.stringify(document.getElementById('{identity}').data)"
    )


def choose(driver, identity, key):
    """Change a control by keyboard alone."""
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys

    control = driver.find_element(By.ID, identity)
    driver.execute_script("arguments[0].focus()", control)
    control.send_keys(getattr(Keys, key))


def test_draws_every_plot_without_a_word_on_the_console(page):
    for identity in PLOTS:
        wait(page, f"return !!document.querySelector('#{identity} svg.main-svg')")
    assert complaints(page) == []
    assert page.execute_script("return document.querySelectorAll('.waiting').length") == 0


def test_asks_no_network(page):
    # the browser's own empty page came before
    asked = [url for url in requested(page) if not url.startswith(("chrome:", "file:"))]
    assert asked == []


@pytest.mark.parametrize(
    ("control", "plot"),
    [
        ("map-metric", "plot-map"),
        ("view-condition", "marginal-first"),
        ("view-condition", "joint-table"),
        ("view-first", "marginal-first"),
        ("view-second", "joint-gap"),
        ("race-metric", "plot-race"),
        ("race-cost", "plot-race"),
        ("design-metric", "plot-designs"),
        ("design-cost", "plot-designs"),
        ("size-metric", "plot-sizes"),
    ],
)
def test_controls_change_their_plots_by_keyboard(page, control, plot):
    before = marks(page, plot), label(page, plot)
    last = page.execute_script(
        f"const s = document.getElementById('{control}'); return s.selectedIndex === s.length - 1"
    )
    choose(page, control, "ARROW_UP" if last else "ARROW_DOWN")
    after = marks(page, plot), label(page, plot)
    assert after[0] != before[0]
    assert after[1] != before[1]
    assert complaints(page) == []


def test_the_same_component_cannot_be_chosen_twice(page):
    first = page.execute_script("return document.getElementById('view-first').value")
    disabled = page.execute_script(
        "return [...document.getElementById('view-second').options]"
        ".filter((o) => o.disabled).map((o) => o.value)"
    )
    assert disabled == [first]


def test_focus_can_be_seen(page):
    style = page.execute_script(
        "const e = document.querySelector('nav a'); e.focus({ focusVisible: true });"
        "const s = getComputedStyle(e); return [s.outlineStyle, parseFloat(s.outlineWidth)]"
    )
    assert style[0] == "solid"
    assert style[1] >= 2.0


@pytest.mark.parametrize("width", [375, 768, 1280])
def test_nothing_is_wider_than_the_screen(page, width):
    resize(page, width)
    wait(page, f"return innerWidth === {width}")
    page.execute_script("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    time.sleep(0.5)
    try:
        assert page.execute_script("return document.documentElement.scrollWidth") <= width
    finally:
        page.execute_script(
            "document.querySelectorAll('details').forEach((d) => { d.open = false; })"
        )
        resize(page, 1280)


WIDEST = """Math.max(...[...document.querySelectorAll(".js-plotly-plot svg.main-svg")].map(
  (svg) => svg.getBoundingClientRect().width))"""


def test_plots_fit_the_paper_as_soon_as_the_page_is_printed(page):
    assert page.execute_script(f"return {WIDEST}") > 700
    # the browser prints what is there when this returns
    printed = page.execute_script(f"dispatchEvent(new Event('beforeprint')); return {WIDEST}")
    assert printed <= 700
    page.execute_script("dispatchEvent(new Event('afterprint'))")
    wait(page, f"return {WIDEST} > 700")
    assert complaints(page) == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out(page, scheme):
    prefer(page, scheme)
    paper = "(20, 23, 26)" if scheme == "dark" else "(255, 255, 255)"
    wait(page, f"return getComputedStyle(document.body).backgroundColor.includes('{paper}')")
    time.sleep(0.3)
    *worst, count = page.execute_script(CONTRAST)
    assert count[0] > 300
    assert all(margin >= 0.0 for margin, _ in worst), worst
    # and the measure sees what cannot be read
    page.execute_script("document.querySelector('h1').style.color = 'rgb(128, 128, 128)'")
    page.execute_script("document.querySelector('h1').style.backgroundColor = 'rgb(140, 140, 140)'")
    assert page.execute_script(CONTRAST)[0][0] < 0.0
    page.execute_script("document.querySelector('h1').removeAttribute('style')")
    prefer(page, "light")
