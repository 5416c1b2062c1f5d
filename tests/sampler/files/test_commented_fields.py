"""Fields in the comments at the top of a data file."""

from sampler.files import commented_fields

TEXT = """\
# title: First
#wall:  steel: ground
#
# prose: is a field as well, if its first word is
# A capital: is prose
# title: a second one does not count
#  indented_too: yes

# after_a_blank_line: still
alpha_deg
# after: the first line of data
"""


def test_fields_before_the_first_line_of_data():
    assert commented_fields(TEXT) == {
        "title": "First",
        "wall": "steel: ground",
        "prose": "is a field as well, if its first word is",
        "indented_too": "yes",
        "after_a_blank_line": "still",
    }


def test_what_would_control_a_terminal_is_left_out():
    assert commented_fields("# title: a\x1b[2J\n# wall: b\n") == {"wall": "b"}
    assert commented_fields("") == {}
