"""The page of a report in a real browser: draws, reacts, fits a phone, has a dark side."""

import time

import pytest
from browser import browser, complaints, missing, prefer, requested, resize

from tablegen.evidence.report_page import report_page

pytest.importorskip("plotly")
pytestmark = pytest.mark.skipif(missing() is not None, reason=str(missing()))

DRAWN = "return document.querySelectorAll('.plotly-graph-div svg.main-svg').length"

#: Choose every entry of every menu; how many there were, or what went wrong.
PRESS_ALL = """
const done = arguments[0];
(async () => {
  let count = 0;
  for (const plot of document.querySelectorAll(".plotly-graph-div")) {
    for (const menu of plot.layout.updatemenus || []) {
      for (const button of menu.buttons) {
        await Plotly.update(plot, ...button.args);
        count += 1;
      }
    }
  }
  done(count);
})().catch((error) => done(String(error)));
"""


@pytest.fixture(scope="module")
def page(report, tmp_path_factory):
    """The page, opened and drawn."""
    folder = tmp_path_factory.mktemp("browser")
    file = folder / "report.html"
    file.write_text(report_page(report), encoding="utf-8")
    with browser(folder / "profile") as driver:
        resize(driver, 1280)
        driver.get(file.as_uri())
        wait(driver, "return document.documentElement.dataset.ready === 'yes'")
        yield driver


def wait(driver, question, seconds=30.0):
    """Ask until the answer is true."""
    end = time.monotonic() + seconds
    while not driver.execute_script(question):
        assert time.monotonic() < end, question
        time.sleep(0.05)


def test_draws_every_plot_and_asks_no_network(page):
    plots = page.execute_script("return document.querySelectorAll('.plotly-graph-div').length")
    assert plots == 9
    assert page.execute_script(DRAWN) >= plots
    assert complaints(page) == []
    assert requested(page) == []


def test_every_entry_of_every_menu_draws(page):
    assert page.execute_async_script(PRESS_ALL) > 50
    assert complaints(page) == []


@pytest.mark.parametrize("width", [375, 1280])
def test_nothing_is_wider_than_the_screen(page, width):
    resize(page, width)
    wait(page, f"return innerWidth === {width}")
    page.execute_script("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    # plots that were folded take the width of the page as they are shown
    widths = "[...document.querySelectorAll('.plotly-graph-div')].map((p) => p._fullLayout.width)"
    least = 0.8 * min(width, 1088)
    wait(page, f"const w = {widths}; return Math.min(...w) > {least} && Math.max(...w) <= {width}")
    assert page.execute_script("return document.documentElement.scrollWidth") <= width


def test_dark_pages_are_dark_with_their_plots(page):
    look = (
        "const plot = getComputedStyle(document.querySelector('.plotly-graph-div'));"
        "return [getComputedStyle(document.body).backgroundColor, plot.filter.includes('invert')]"
    )
    found = []
    for scheme in ("light", "dark"):
        prefer(page, scheme)
        found.append(page.execute_script(look))
    assert found == [["rgb(255, 255, 255)", False], ["rgb(20, 20, 20)", True]]
