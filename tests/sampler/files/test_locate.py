"""Tables and configurations by name or path."""

import doctest
import shutil

import pytest

import sampler
from sampler import InputError
from sampler.files import locate


@pytest.fixture
def data(tmp_path, table_path, monkeypatch):
    """A data folder of our own: what is shipped shall not decide these tests."""
    folder = tmp_path / "data"
    folder.mkdir()
    shutil.copy(table_path, folder / "corundum-steel.h5")
    (folder / "corundum-steel.toml").write_text("")
    (folder / "demo.toml").write_text("")
    monkeypatch.setattr(locate, "data_directory", lambda: folder)
    monkeypatch.chdir(tmp_path)
    return folder


def test_names(data):
    assert locate.available(".h5") == ["corundum-steel"]
    assert locate.available(".toml") == ["corundum-steel", "demo"]
    assert locate.find_table("corundum-steel") == data / "corundum-steel.h5"
    assert locate.find_config("demo") == data / "demo.toml"


def test_a_name_does_not_depend_on_the_working_folder(data, tmp_path):
    (tmp_path / "corundum-steel").mkdir()
    assert locate.find_table("corundum-steel") == data / "corundum-steel.h5"


def test_paths(data, tmp_path):
    path = tmp_path / "mine.h5"
    shutil.copy(data / "corundum-steel.h5", path)
    assert locate.find_table(path) == path
    assert locate.find_table("mine.h5").samefile(path)
    assert sampler.load(str(path)).pair == "made-up"


@pytest.mark.usefixtures("data")
def test_unknown_names_and_paths(tmp_path):
    with pytest.raises(
        InputError, match=r"table: got 'quartz', allowed: a name \(corundum-steel\)"
    ):
        locate.find_table("quartz")
    with pytest.raises(InputError, match=r"a name \(corundum-steel, demo\) or the path of a .toml"):
        locate.find_config("quartz")
    with pytest.raises(InputError, match=r"table: got none.h5, allowed: a file that exists"):
        locate.find_table("none.h5")
    with pytest.raises(InputError, match=r"table: got 'n+', allowed: a name"):
        locate.find_table("n" * 400)
    with pytest.raises(InputError, match=r"a folder, allowed: a \.h5 file"):
        locate.find_table(tmp_path)


def test_the_data_folder_of_this_checkout():
    folder = sampler.data_directory()
    assert folder.is_dir()
    assert folder.name in ("tables", "_tables")


def test_no_data_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(locate, "_PACKAGE", tmp_path / "nowhere" / "sampler")
    with pytest.raises(InputError, match="data folder: none"):
        locate.data_directory()


@pytest.mark.usefixtures("data")
def test_example_in_the_package_docstring():
    result = doctest.testmod(sampler)
    assert result.attempted > 0
    assert result.failed == 0
