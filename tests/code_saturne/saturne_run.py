"""Running code_saturne on the box: build once, then runs of a few seconds, a folder each."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

SOURCES = Path(__file__).resolve().parents[2] / "sampler" / "code_saturne"
HEADER = SOURCES.parent / "c" / "rebound_sampler.h"
BOX = Path(__file__).resolve().parent / "box"
TABLE = "corundum-steel.rbt"
#: Corners of the box [m], and its cells.
LOWER, UPPER = np.array([-0.4, 0.0, -0.4]), np.array([0.4, 0.4, 0.4])
CELLS = (8, 4, 8)


class SaturneError(RuntimeError):
    """A program of code_saturne failed; the message is the text of its error files."""


def _environment():
    """Variables that code_saturne needs: a user's name, and one thread a process."""
    return {
        **os.environ,
        "USER": os.environ.get("USER", "nobody"),
        "LOGNAME": os.environ.get("LOGNAME", "nobody"),
        "OMP_NUM_THREADS": "1",
        # Open MPI asks root for these, and counts the cores of a container differently from us
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
    }


def call(folder, *command):
    """Run a program in a folder; its output is kept as NAME.log there."""
    words = [str(word) for word in command]
    done = subprocess.run(
        words,
        cwd=folder,
        env=_environment(),
        text=True,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    (Path(folder) / f"{Path(words[0]).name}.log").write_text(done.stdout, encoding="utf-8")
    if done.returncode != 0:
        errors = sorted(Path(folder).glob("error*"))
        errors_text = "".join(path.read_text(encoding="utf-8", errors="replace") for path in errors)
        raise SaturneError(f"{' '.join(words)} in {folder}:\n{errors_text or done.stdout[-3000:]}")


def write_mesh(path):
    """Write the box as a Gmsh 2 file: hexahedra and nothing else; sides become boundary faces."""
    shape = tuple(n + 1 for n in CELLS)
    axes = [np.linspace(*ends) for ends in zip(LOWER, UPPER, shape, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(1, len(nodes) + 1).reshape(shape)
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = np.stack(
        [
            number[i : i + CELLS[0], j : j + CELLS[1], k : k + CELLS[2]].ravel()
            for k in (0, 1)
            for i, j in corners
        ],
        axis=1,
    )
    rows = [f"{n} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(nodes.tolist(), start=1)]
    hexahedra = [
        f"{n} 5 2 1 1 {' '.join(map(str, cell))}" for n, cell in enumerate(cells.tolist(), start=1)
    ]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    text += ["$Nodes", str(len(rows)), *rows, "$EndNodes"]
    text += ["$Elements", str(len(hexahedra)), *hexahedra, "$EndElements", ""]
    path.write_text("\n".join(text), encoding="ascii")


def build(work):
    """Make WORK/box: the solver with our user sources and those of the box, and the mesh."""
    folder = Path(work) / "box"
    sources = [*SOURCES.glob("src/rebound_*.[ch]"), *BOX.glob("*"), HEADER]
    if not (folder / "cs_solver").exists():
        (folder / "SRC").mkdir(parents=True)
        for path in sources:
            shutil.copy(path, folder / "SRC")
        call(folder, "code_saturne", "compile", "--source", folder / "SRC", "--dest", folder)
    if not (folder / "mesh_input").exists():
        write_mesh(folder / "box.msh")
        preprocess = Path("/usr/lib/code_saturne/cs_preprocess")
        call(folder, preprocess, "--out", "mesh_input", "box.msh")
    return folder


def settings(**changed):
    """Text of rebound_wall.cfg: the file that is shipped, with values changed or added.

    The gas has no torque unless it is named.
    """
    changed = {"gas_torque": 0, **changed}
    lines = (SOURCES / "src" / "rebound_wall.cfg").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not line.startswith(tuple(changed))]
    return "\n".join([*kept, *(f"{name} {value}" for name, value in changed.items()), ""])


def run(work, folder, steps, *, step, particles, processors=1, restart=None, symmetry=0, text=None):
    """Run the box in a new folder, and return that folder.

    `steps` counts those before a restart too, `step` is their length [s]; `particles` are injected
    at the beginning; `restart` is the folder of a run that goes on; `symmetry` is 1 for symmetry
    planes at both ends in x, 2 at all four sides; `text` is that of the settings.
    """
    built, folder = build(work), Path(folder)
    folder.mkdir(parents=True)
    shutil.copy(built / "mesh_input", folder)
    (folder / TABLE).symlink_to(Path(work) / TABLE)
    (folder / "rebound_wall.cfg").write_text(text or settings(), encoding="utf-8")
    numbers = (steps, step, particles, int(restart is not None), symmetry)
    (folder / "box.txt").write_text(" ".join(map(str, numbers)), encoding="ascii")
    if restart is not None:
        (folder / "restart").symlink_to(Path(restart) / "checkpoint")
    parallel = ["mpiexec", "-n", str(processors)] if processors > 1 else []
    call(folder, *parallel, built / "cs_solver", *(["--mpi"] if parallel else []))
    return folder
