"""Outputs appear whole or not at all."""

import pytest

from sampler import InputError
from sampler.files.atomic import atomic_output, check_output


def test_moved_into_place_at_the_end(tmp_path):
    target = tmp_path / "out.txt"
    with atomic_output(target) as temporary:
        temporary.write_text("whole")
        assert not target.exists()
        assert temporary.parent == target.parent
    assert target.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_left_after_a_failure(tmp_path, error):
    target = tmp_path / "out.txt"
    target.write_text("earlier")

    def fail():
        with atomic_output(target) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert target.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [target]


def test_failure_to_write_is_one_line(tmp_path):
    with (
        pytest.raises(InputError, match=r"output: cannot write .*: File name too long"),
        atomic_output(tmp_path / ("n" * 400)) as temporary,
    ):
        temporary.write_text("half")
    assert not list(tmp_path.iterdir())


def test_paths_that_cannot_work(tmp_path):
    with pytest.raises(InputError, match="a folder, allowed: a file name"):
        check_output(tmp_path)
    with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
        check_output(tmp_path / "none" / "out.npz")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="allowed: a file in a folder that exists"):
        check_output(tmp_path / "file" / "out.npz")
