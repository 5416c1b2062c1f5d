"""Files of measured rebounds: what is read, and every bad input in one line."""

from contextlib import suppress
from itertools import product

import numpy as np
import pytest
from refusals import refused

from sampler.errors import InputError
from sampler.files import available
from tablegen.measured.reader import parse_measurements, read_measurements

GOOD = """\
# title: Made up
# particle: sand
#
# a comment: of two words is no field

alpha_deg, speed, e_n, e_n_std, e_t, omega_z, count, source, remarks
30,100,0.5,0.1,0.7,-0.4,250,"Smith, 1999",first
30,200,0.45,,0.7,,,Smith,
90,100,.2,5e-2,,,,Smith,"with
# ""quotes"" in"
"""


def read(text):
    return parse_measurements(text, "made-up", "made-up.csv")


def test_a_file_is_read(tmp_path):
    path = tmp_path / "made-up.csv"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    measurements = read_measurements(path)
    assert measurements.about == {"title": "Made up", "particle": "sand"}
    np.testing.assert_array_equal(measurements.alpha_deg, [30.0, 30.0, 90.0])
    np.testing.assert_array_equal(measurements.speed, [100.0, 200.0, 100.0])
    np.testing.assert_array_equal(measurements.moments["e_n"].mean, [0.5, 0.45, 0.2])
    np.testing.assert_array_equal(measurements.moments["e_n"].std, [0.1, np.nan, 0.05])
    np.testing.assert_array_equal(measurements.moments["omega_z"].mean, [-0.4, np.nan, np.nan])
    assert np.isnan(measurements.moments["out_of_plane_deg"].mean).all()
    np.testing.assert_array_equal(measurements.count, [250.0, np.nan, np.nan])
    assert measurements.source[0] == "Smith, 1999"
    assert measurements.remarks == ("first", "", 'with # "quotes" in')


def test_a_spread_out_of_the_plane_needs_no_mean():
    measurements = read("alpha_deg,e_n,out_of_plane_deg_std,source\n30,0.5,4,s\n60,0.4,,s\n")
    np.testing.assert_array_equal(measurements.moments["out_of_plane_deg"].mean, [0.0, np.nan])
    np.testing.assert_array_equal(measurements.moments["out_of_plane_deg"].std, [4.0, np.nan])


def row(cells, columns="alpha_deg,speed,e_n,e_n_std,e_t,source"):
    return f"{columns}\n{cells}\n"


SOURCE = "alpha_deg,{},source"

#: Wrong texts, and the one line about each after the name of the file.
WRONG = [
    ("# title: x\n", r": has no line but comments; begin with a line of column names"),
    ("alpha_deg,e_n,source\n", r": got 0 rows, allowed: 1 to 10000"),
    (row("0.5,s", "e_n,source"), r": line 1: column 'alpha_deg' is missing; give "),
    (row("30,s", "alpha_deg,source"), r": line 1: there is no measured quantity"),
    (row("30,1,s", SOURCE.format("e_m")), r": line 1: got column 'e_m', allowed: alpha"),
    (row("30,1,1,s", SOURCE.format("e_n,e_n")), r": line 1: got column 'e_n' twice"),
    ("alpha_deg;e_n;source\n30;0,5;s\n", r": line 1: got semicolons between"),
    ("alpha_deg\te_n\tsource\n30\t0.5\ts\n", r": line 1: got tabs or spaces between"),
    (row("0,,0.5,,,s"), r": line 2, alpha_deg: got 0, allowed: 1e-06 to 90 \(degrees"),
    (row("30,,0.5,,, "), r": line 2, source: the cell is empty"),
    (row("30,10,,,,s"), r": line 2: there is no measured quantity"),
    (row("30,,43,,,s"), r": line 2, e_n: got 43, allowed: 0 to 2.002"),
    (row("30,,0.4,-0.1,,s"), r": line 2, e_n_std: got -0.1, allowed: 0 to"),
    (row("30,,,0.1,0.5,s"), r"e_n_std: got 0.1, allowed: a spread beside its mean only; give e_n"),
    (row("90,,0.4,,0.9,s"), r": line 2, e_t: got 0.9, allowed: an empty cell at 90"),
    (row("30,0,0.4,,,s"), r": line 2, speed: got 0, allowed: 1e-06 to 1e\+05 \(m/s\)"),
    (row("30,,0.4,,s"), r": line 2: got 5 cells, allowed: 6"),
    (row('30,,0.4,,,"s'), r": line 2: unexpected end of data; put commas"),
    (row("30,0.4,2.5,s", SOURCE.format("e_n,count")), r", count: got 2.5, allowed: 1 to"),
    (row("30,-612,s", SOURCE.format("omega_z")), r"omega_z: got -612, .*, not rad/s\)$"),
    (row("30,181,s", SOURCE.format("rebound_angle_deg")), r"got 181, .*180"),
    (row("30,100,0.4,,,s\n\n30,100,0.5,,,s"), r": line 4, e_n: got a second value at 30 deg"),
    (row("30,100,0.4,,,s\n# x\n60,100,0.5,,,s"), r": line 3: a row begins with #; delete it, or"),
    (
        row("#1 of 2026,30,100,0.4,s", "remarks,alpha_deg,speed,e_n,source"),
        r": line 2: a row begin",
    ),
    (
        row('"#1, 2026",30,100,0.4,s', "remarks,alpha_deg,speed,e_n,source"),
        r": line 2: a row begin",
    ),
    (row("0.3,,0.6,,,s\n1.2,,0.4,,,s"), r": line 2, alpha_deg: got angles up to 1.2, which look"),
    (row("20,,0.4,,,s\n20.0000000001,,0.5,,,s"), r": line 3, e_n: got a second value at 20 deg"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_bad_input_is_one_line(text, message):
    with pytest.raises(InputError, match=r"^made-up\.csv" + "(?:.*)" + message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


#: A file of which each cell is replaced; cells that are no number, and ways to write one.
ROWS = [
    ["alpha_deg", "speed", "e_n", "e_n_std", "e_t", "omega_z", "count", "source"],
    ["30", "100", "0.5", "0.1", "0.7", "-0.4", "250", "s"],
    ["60", "200", "0.25", "0.05", "0.5", "0.125", "16", "s"],
]
HOSTILE = (
    "1_0",
    "٤٠",
    "x",
    "0,5",
    "nan",
    "-inf",
    "1e999",
    "5%",
    "1/2",
    "--3",
    "1e",
    "0x1F",
    "½",
    "=A1",
    "1 2",
)
HONEST = ("{}", " {:.6f}", "{:+.3e} ", '"{:g}"')


def with_cell(line, column, cell):
    rows = [list(row) for row in ROWS]
    rows[line - 1][column] = cell
    return "\n".join(",".join(row) for row in rows)


@pytest.mark.parametrize("cell", HOSTILE)
def test_a_cell_that_is_no_number_is_named(cell):
    for line, column in product((2, 3), range(7)):
        field = f"made-up.csv: line {line}, {ROWS[0][column]}"
        refused(field, read, with_cell(line, column, f'"{cell}"'))


@pytest.mark.parametrize("form", HONEST)
def test_a_number_may_be_written_in_several_ways(form):
    for line, column in product((2, 3), range(7)):
        same = read(with_cell(line, column, form.format(float(ROWS[line - 1][column]))))
        np.testing.assert_equal(vars(same), vars(read(with_cell(1, 0, "alpha_deg"))))


def test_a_missing_character_is_read_or_refused():
    for k in range(len(GOOD)):
        with suppress(InputError):
            assert len(read(GOOD[:k] + GOOD[k + 1 :]).alpha_deg) in (2, 3)


def test_files_that_cannot_be_read(tmp_path):
    path = tmp_path / "wrong.csv"
    path.write_bytes(b"alpha_deg,e_n,source\n30,0.5,\xff\n")
    assert "byte 0xff at position 28" in refused("wrong.csv", read_measurements, path)
    refused("measurements", read_measurements, tmp_path)
    refused("measurements", read_measurements, "nobody-1900")
    rows = "".join(f"{k / 200 + 1},0.1,s\n" for k in range(10_001))
    assert "10001 rows" in refused("made-up.csv", read, "alpha_deg,e_n,source\n" + rows)


#: Published polynomials in rad or degrees, lowest power first, typed anew here.
PUBLISHED = {
    ("grant-tabakoff-1975", "e_n", "mean"): (0.993, -1.76, 1.56, -0.49),
    ("grant-tabakoff-1975", "e_t", "mean"): (0.988, -1.66, 2.11, -0.67),
    ("grant-tabakoff-1975", "e_n", "std"): (0.0, 2.15, -5.02, 4.05, -1.085),
    ("grant-tabakoff-1975", "e_t", "std"): (-0.0005, 0.62, -0.535, 0.089),
    ("forder-1998", "e_n", "mean"): (0.988, -0.78, 0.19, -0.024, 0.027),
    ("forder-1998", "e_t", "mean"): (1.0, -0.78, 0.84, -0.21, 0.028, -0.022),
    ("wakeman-tabakoff-1981", "e_n", "mean"): (1.0, -0.0211, 0.000228, -8.76e-7),
    ("wakeman-tabakoff-1981", "e_t", "mean"): (0.953, 0.0, -0.000446, 6.48e-6),
}


@pytest.mark.parametrize("key", PUBLISHED, ids=" ".join)
def test_shipped_rows_are_the_published_polynomials(key):
    name, quantity, which = key
    measurements = read_measurements(name)
    np.testing.assert_array_equal(measurements.alpha_deg, range(10, 91, 10))
    values = getattr(measurements.moments[quantity], which)
    x = measurements.alpha_deg if name.startswith("wakeman") else np.radians(measurements.alpha_deg)
    expected = np.polynomial.Polynomial(PUBLISHED[key])(x)
    given = np.isfinite(values)
    # digits that are shipped
    np.testing.assert_allclose(values[given], expected[given], atol=0.5001e-4)
    steep = 60.0 if name.startswith("wakeman") else 90.0
    np.testing.assert_array_equal(given, (quantity == "e_n") | (measurements.alpha_deg < steep))


def test_every_shipped_file_says_where_it_is_from():
    names = available(".csv")
    assert {key[0] for key in PUBLISHED} | {"kharaz-2001"} <= set(names)
    for name in names:
        measurements = read_measurements(name)
        assert all(measurements.source)
        assert {"title", "particle", "wall"} <= set(measurements.about)


def test_what_excel_writes_is_read():
    """Trailing commas on every line, empty rows of commas, quoted comments, ends of Windows."""
    text = (
        '"# title: sand, on steel",,,,,\n,,,,,\nalpha_deg,e_n,source,,,\n'
        '30,0.5,"a, b",,,\n45,0.4,c,,,\n,,,,,\n'
    )
    measurements = read(text)
    assert measurements.about["title"] == "sand, on steel"
    assert measurements.alpha_deg.tolist() == [30.0, 45.0]
    assert measurements.source == ("a, b", "c")
