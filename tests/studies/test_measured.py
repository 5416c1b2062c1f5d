"""The page on measured and computed rebounds shows what its program prints."""

import contextlib
import io

import measured
import numpy as np
import pytest
from documents import ROOT, blocks

from sampler.files import parse_number

#: Grains at each condition. Chance errors are then five times those of the page.
COUNT = 4000


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    picture = tmp_path_factory.mktemp("measured") / "measured.png"
    with contextlib.redirect_stdout(io.StringIO()) as output:
        measured.main(["--count", str(COUNT), "--picture", str(picture)])
    assert picture.stat().st_size > 10_000
    return output.getvalue()


def test_the_page_shows_what_the_program_prints(printed):
    page = (ROOT / "docs" / "measured.md").read_text(encoding="utf-8")
    shown = [block.text for block in blocks(page) if block.language == "text"]
    for now, then in zip(printed.split("\n\n"), shown[:1] + shown[1].split("\n\n"), strict=True):
        for line, page_line in zip(now.strip().split("\n"), then.strip().split("\n"), strict=True):
            # chance moves the angle of the largest deviation
            end = -1 if "fitted" in line else None
            words, page_words = line.split()[:end], page_line.split()[:end]
            assert len(words) == len(page_words)
            for word, page_word in zip(words, page_words, strict=True):
                number, page_number = parse_number(word), parse_number(page_word)
                if np.isnan(number):
                    assert word == page_word
                else:
                    assert abs(number - page_number) < 0.02 + 0.1 * abs(page_number), line


def test_measured_mean_of_corundum():
    """Values of the source of equation (6) at 200 m/s, worked out by hand."""
    mean = measured.measured_mean(np.radians([10.0, 30.0, 90.0]), 200.0)
    np.testing.assert_allclose(mean, [0.1459, 0.2699, 0.0794], atol=5e-5)


def test_where_the_page_says_that_the_model_agrees(printed):
    rows = [line.split() for line in printed.splitlines()[2:12]]
    off = {int(angle): abs(float(difference)) for angle, *_, difference in rows}
    assert max(off[angle] for angle in off if angle >= 30) < 0.03
    assert min(off[angle] for angle in off if angle <= 20) > 0.03
