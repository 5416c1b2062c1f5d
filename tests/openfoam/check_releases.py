"""Compile the plugin against the headers of releases of OpenFOAM, which need not be installed.

    python tests/openfoam/check_releases.py SOURCE...

SOURCE is a source tree of a release, or REPOSITORY@REVISION of a git repository. Each translation
unit of the plugin is compiled by `g++ -fsyntax-only`, with the flags of the release's own wmake
rules and the plugin's own Make/options, all templates with it. So every name and every overridden
signature is checked; nothing is linked and nothing runs.

Prints a line for each release: "compiled", "does not compile" or "not checked", and why. Ends with
1 if one does not compile.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

PLUGIN = Path(__file__).resolve().parents[2] / "sampler" / "openfoam" / "plugin"
#: Environment of wmake's rules.
SETTINGS = {
    "WM_ARCH": "linux64",
    "WM_ARCH_OPTION": "64",
    "WM_COMPILER": "Gcc",
    "WM_COMPILE_OPTION": "Opt",
    "WM_LABEL_SIZE": "32",
    "WM_LINK_LANGUAGE": "c++",
    "WM_PRECISION_OPTION": "DP",
}
FLAGS = """
GENERAL_RULES = $(WM_DIR)/rules/General
include $(GENERAL_RULES)/general
include $(PLUGIN)/Make/options
flags:
	@echo $(CC) $(GFLAGS) $(ptFLAGS) $(EXE_INC)
"""
HEADERS = (".H", ".C", ".h", ".hh", ".hpp", ".hxx", ".tcc", ".tpp", ".txx", ".cpp", ".cxx", ".type")


class NotCheckedError(Exception):
    """A release that cannot be checked; the message says why."""


def _output(*command, **given):
    """Output of a program, or `NotCheckedError` with its last line."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, **given)
    except FileNotFoundError:
        raise NotCheckedError(f"no {command[0]} here") from None
    if done.returncode:
        raise NotCheckedError((done.stderr.strip().splitlines() or ["it failed"])[-1])
    return done.stdout.strip()


def unpack(repository, revision, folder):
    """Take the parts of a revision that are needed out of a git repository."""
    git = ("git", "-C", str(repository))
    _output(*git, "rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}")
    known = _output(*git, "ls-tree", "--name-only", revision).split()
    archive = str(folder / "part.tar")
    # one by one: git looks at all of a tree that it archives a part of, and may lack what is large
    for part in sorted({"src", "wmake", "etc", "META-INFO"} & set(known)):
        _output(*git, "archive", "-o", archive, f"--prefix={part}/", f"{revision}:{part}")
        _output("tar", "xf", archive, "-C", str(folder))


def release_name(tree, otherwise):
    information = tree / "META-INFO" / "api-info"
    if information.exists():
        return f"OpenFOAM.com v{information.read_text().split('api=')[1].split()[0]}"
    settings = tree / "etc" / "bashrc"
    lines = settings.read_text().splitlines() if settings.exists() else []
    versions = [x.split("=")[1] for x in lines if x.startswith("export WM_PROJECT_VERSION=")]
    if not versions or versions[0] == "dev":
        return f"OpenFOAM.org {otherwise}"
    return f"OpenFOAM.org {versions[0]}"


def link_headers(tree, folder):
    """Give every library of a tree its folder lnInclude, in a mirror of the tree's src."""
    for made in sorted((tree / "src").rglob("Make/files")):
        library = made.parents[1]
        links = folder / library.relative_to(tree / "src") / "lnInclude"
        links.mkdir(parents=True, exist_ok=True)
        for at, folders, names in os.walk(library):
            folders[:] = sorted(set(folders) - {"lnInclude", "Make", "config", "noLink"})
            for name in names:
                link = links / name
                if name.endswith(HEADERS) and not link.is_symlink():
                    link.symlink_to(Path(at) / name)


def compiler(tree, headers):
    """Compiler and flags by which wmake of the release would compile the plugin."""
    known = [headers / "lagrangian" / name for name in ("intermediate", "parcel")]
    if not any(path.exists() for path in known):
        raise NotCheckedError("no library with clouds among its sources")
    given = {"WM_DIR": tree / "wmake", "PLUGIN": PLUGIN, "LIB_SRC": headers}
    given |= {"REBOUND_SAMPLER_INCLUDE": PLUGIN.parents[1] / "c", **SETTINGS}
    words = [f"{name}={value}" for name, value in given.items()]
    flags = _output("make", "-s", "-f", "-", *words, "flags", input=FLAGS).split()
    common = (headers / "OpenFOAM", headers / "OSspecific" / "POSIX")
    return [*flags, *(f"-I{path}/lnInclude" for path in common), f"-I{PLUGIN}"]


def first_error(command, unit):
    """First error of a translation unit, None if it compiles."""
    done = subprocess.run(
        [*command, "-w", "-fsyntax-only", str(unit)], capture_output=True, text=True, check=False
    )
    if done.returncode == 0:
        return None
    lines = done.stderr.splitlines()
    return next((line for line in lines if "error:" in line), lines[-1])


def check(source, folder):
    """Compile against one release, with an empty folder; return its name, headers and result."""
    place, _, revision = source.partition("@")
    name, described, tree = source, "", Path(place).resolve()
    try:
        if not tree.is_dir():
            raise NotCheckedError("no such folder")
        if revision:
            unpack(place, revision, folder)
            log = ("log", "-1", "--format=%h, %cs", "--abbrev=10", revision)
            described, tree = _output("git", "-C", place, *log), folder
        name = release_name(tree, revision.removeprefix("version-") or "of unknown version")
        headers = folder / "headers"
        link_headers(tree, headers)
        command = compiler(tree, headers)
    except NotCheckedError as error:
        return name, described, f"not checked: {error}"
    for unit in (PLUGIN / "Make" / "files").read_text().split():
        error = first_error(command, PLUGIN / unit) if unit.endswith(".C") else None
        if error is not None:
            return name, described, f"does not compile: {unit}: {error}"
    return name, described, "compiled"


def main(sources):
    failed = 0
    print("| release | headers | result |\n|---|---|---|")
    for source in sources:
        with tempfile.TemporaryDirectory() as folder:
            row = check(source, Path(folder))
        print(f"| {' | '.join(row)} |", flush=True)
        failed += row[2].startswith("does not compile")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
