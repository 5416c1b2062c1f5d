"""Compile the plugin against the headers of OpenFOAM releases that are not installed.

    python tests/openfoam/check_releases.py SOURCE...

SOURCE is a source tree of a release. Each translation unit of the plugin is compiled by
`g++ -fsyntax-only`, with the flags of the release's own wmake rules and the plugin's own
Make/options, all templates with it. So every name and every overridden signature is checked;
nothing is linked and nothing runs.

Prints a line for each release: "compiled", or "does not compile" and why. Ends with 1 if one does
not.
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


def release_name(tree):
    information = tree / "META-INFO" / "api-info"
    if information.exists():
        return f"OpenFOAM.com v{information.read_text().split('api=')[1].split()[0]}"
    settings = tree / "etc" / "bashrc"
    lines = settings.read_text().splitlines() if settings.exists() else []
    versions = [x.split("=")[1] for x in lines if x.startswith("export WM_PROJECT_VERSION=")]
    return f"OpenFOAM.org {versions[0]}" if versions else str(tree)


def link_headers(tree, folder):
    """Make a folder lnInclude for every library of a source tree, in a copy of its src."""
    for makefile in sorted((tree / "src").rglob("Make/files")):
        library = makefile.parents[1]
        links = folder / library.relative_to(tree / "src") / "lnInclude"
        links.mkdir(parents=True, exist_ok=True)
        for at, folders, names in os.walk(library):
            folders[:] = sorted(set(folders) - {"lnInclude", "Make", "config", "noLink"})
            for name in names:
                link = links / name
                if name.endswith(HEADERS) and not link.is_symlink():
                    link.symlink_to(Path(at) / name)


def compiler(tree, headers):
    """Return the compiler and the flags with which wmake of a release would compile the plugin."""
    given = {"WM_DIR": tree / "wmake", "PLUGIN": PLUGIN, "LIB_SRC": headers}
    given |= {"REBOUND_SAMPLER_INCLUDE": PLUGIN.parents[1] / "c", **SETTINGS}
    words = [f"{name}={value}" for name, value in given.items()]
    command = ["make", "-s", "-f", "-", *words, "flags"]
    flags = subprocess.check_output(command, input=FLAGS, text=True)
    common = (headers / "OpenFOAM", headers / "OSspecific" / "POSIX")
    return [*flags.split(), *(f"-I{path}/lnInclude" for path in common), f"-I{PLUGIN}"]


def first_error(command, unit):
    """Compile a file, and return its first error, or None."""
    done = subprocess.run(
        [*command, "-w", "-fsyntax-only", str(unit)], capture_output=True, text=True, check=False
    )
    if done.returncode == 0:
        return None
    lines = done.stderr.splitlines()
    return next((line for line in lines if "error:" in line), lines[-1])


def check(tree, headers):
    """Compile against one release in a new folder of headers; return the release and the result."""
    name = release_name(tree)
    link_headers(tree, headers)
    command = compiler(tree, headers)
    for unit in (PLUGIN / "Make" / "files").read_text().split():
        error = first_error(command, PLUGIN / unit) if unit.endswith(".C") else None
        if error is not None:
            return name, f"does not compile: {unit}: {error}"
    return name, "compiled"


def main(sources):
    failed = 0
    print("| release | result |\n|---|---|")
    for source in sources:
        with tempfile.TemporaryDirectory() as folder:
            row = check(Path(source).resolve(), Path(folder))
        print(f"| {' | '.join(row)} |", flush=True)
        failed += row[1].startswith("does not compile")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
