"""The plugin against headers of releases that are not installed."""

import shutil
import subprocess

import check_releases
import pytest


def _git(folder, *words):
    author = ("-c", "user.name=a", "-c", "user.email=a@b")
    subprocess.run(["git", "-C", folder, *author, *words], check=True, capture_output=True)


@pytest.fixture
def repository(tmp_path):
    """A release of other sources, in git."""
    tree = tmp_path / "tree"
    (tree / "src" / "mesh" / "Make").mkdir(parents=True)
    (tree / "src" / "mesh" / "Make" / "files").write_text("mesh.C\n")
    (tree / "etc").mkdir()
    (tree / "etc" / "bashrc").write_text("export WM_PROJECT_VERSION=12\n")
    _git(tmp_path, "init", "tree")
    _git(tree, "add", ".")
    _git(tree, "commit", "-m", "release", "--date", "2024-07-06T12:00:00")
    return tree


def _check(source, tmp_path):
    folder = tmp_path / "new"
    folder.mkdir()
    return check_releases.check(str(source), folder)


def test_sources_without_clouds_are_not_checked(repository, tmp_path, capsys):
    verdict = _check(f"{repository}@HEAD", tmp_path)
    assert (verdict.release, verdict.result) == ("OpenFOAM.org 12", "not checked")
    assert verdict.reason == "no library with clouds among its sources"
    assert check_releases.main([str(repository)]) == 0
    row = "| OpenFOAM.org 12 |  | not checked: no library with clouds among its sources |"
    assert capsys.readouterr().out.splitlines()[-1] == row


@pytest.mark.parametrize("source", ["{}/none", "{}/tree@version-1"])
def test_sources_that_are_not_there_are_not_checked(repository, source, tmp_path):
    assert repository.exists()
    verdict = _check(source.format(tmp_path), tmp_path)
    assert verdict.result == "not checked"
    assert verdict.reason


def test_a_release_says_what_it_is(tmp_path):
    assert check_releases.release_name(tmp_path, "14") == "OpenFOAM.org 14"
    (tmp_path / "META-INFO").mkdir()
    (tmp_path / "META-INFO" / "api-info").write_text("api=2306\npatch=0\n")
    assert check_releases.release_name(tmp_path, "14") == "OpenFOAM.com v2306"


@pytest.mark.study  # needs the headers of an installed OpenFOAM, and compiles for a minute
@pytest.mark.parametrize(
    ("file", "old", "new", "error"),
    [
        (None, "", "", None),
        # another signature than OpenFOAM's
        ("compatibility.H", "info(Ostream& os) override", "info() override", "does not override"),
        # in a template that is compiled only where it is used
        ("TabulatedRebound.C", "++counts_.hits;", "++counts_.shots;", "has no member"),
    ],
)
def test_the_plugin_is_compiled_with_its_templates(
    work, tmp_path, monkeypatch, file, old, new, error
):
    plugin = tmp_path / "openfoam" / "plugin"
    shutil.copytree(check_releases.PLUGIN, plugin)
    (tmp_path / "c").symlink_to(check_releases.PLUGIN.parents[1] / "c")
    if file is not None:
        text = (plugin / file).read_text()
        assert old in text
        (plugin / file).write_text(text.replace(old, new))
    monkeypatch.setattr(check_releases, "PLUGIN", plugin)
    verdict = _check(next(work.glob("openfoam-1912.*/")), tmp_path)
    assert verdict.release == "OpenFOAM.com v1912"
    assert verdict.result == ("compiled" if error is None else "does not compile")
    assert (error or "") in verdict.reason
