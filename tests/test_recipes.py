"""The recipes of CONTRIBUTING.md, followed in a copy of the tree; a step that is missing fails."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

#: Compiles the draw in a second.
QUICK = "-O0 -D__SANITIZE_ADDRESS__"


class Tree:
    """A copy of the packages, and of what their tests need to draw."""

    def __init__(self, folder):
        self.folder = folder
        no_tables = shutil.ignore_patterns(
            "*.h5", "*.so", "__pycache__", "openfoam", "code_saturne"
        )
        for name in ("sampler", "tablegen", "tables", "tools"):
            shutil.copytree(ROOT / name, folder / name, ignore=no_tables)
        paths = folder, ROOT / "tests", ROOT / "tests/sampler", ROOT / "tests/tablegen"
        self.environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(map(str, paths)),
            "NUMBA_CACHE_DIR": str(folder / "cache"),
            "CFLAGS": QUICK,
        }

    def edit(self, name, before, after):
        """Replace the only occurrence of a text in a file."""
        path = self.folder / name
        text = path.read_text(encoding="utf-8")
        assert text.count(before) == 1, (name, before)
        path.write_text(text.replace(before, after), encoding="utf-8")

    def run(self, *words):
        done = subprocess.run(
            [sys.executable, *words],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def build(self):
        """Run the commands of the page."""
        self.run("tools/generated_code.py")
        self.run("tools/format_page.py")
        self.run("sampler/c/build.py")


def add_contact_law(tree):
    tree.edit(
        "sampler/formats/bounds.py", '"power", "tabulated")', '"power", "tabulated", "falling")'
    )
    tree.edit(
        "tablegen/model/contact_laws.py",
        "    return law.coefficient\n",
        "    if law.restitution_law == FALLING:\n"
        "        return law.coefficient / (1.0 + law.exponent * contact_speed)\n"
        "    return law.coefficient\n",
    )
    tree.edit(
        "tablegen/model/contact_laws.py",
        'POWER = RESTITUTION_LAWS.index("power")\n',
        'POWER, FALLING = map(RESTITUTION_LAWS.index, ("power", "falling"))\n',
    )
    tree.edit(
        "tablegen/config/pairs.py",
        "RestitutionLaw = (\n",
        "class FallingRestitution(_Restitution):\n"
        '    law: Literal["falling"]\n'
        "    coefficient: Restitution\n"
        "    slowness: Positive\n"
        "    valid_speed: SpeedRange | None = None\n"
        "    source: Text\n"
        "    depends_on_speed = property(lambda self: True)\n\n\n"
        "RestitutionLaw = (\n    FallingRestitution |\n",
    )
    tree.edit(
        "tablegen/config/pairs.py",
        "        case OrientationResistance():\n",
        "        case FallingRestitution():\n"
        '            return {"coefficient": law.coefficient, "exponent": law.slowness}\n'
        "        case OrientationResistance():\n",
    )
    tree.edit(
        "sampler/c/src/sphere.h",
        "    else if (kind == RBTI_RESTITUTION_POWER)\n",
        "    else if (kind == RBTI_RESTITUTION_FALLING)\n"
        "        e = c / (1.0 + exponent * speed);\n"
        "    else if (kind == RBTI_RESTITUTION_POWER)\n",
    )


def add_shape(tree):
    """An octahedron: the middles of the six faces of the box."""
    tree.edit("sampler/formats/shape_codes.py", '"sphere")', '"sphere", "octahedron")')
    tree.edit(
        "sampler/formats/shape_geometry.py",
        '        "sphere": ellipsoid,\n',
        '        "sphere": ellipsoid,\n'
        '        "octahedron": Geometry(4.0 / 3.0, 1.0 / 15.0, 0.0, 4.0),\n',
    )
    shapes = "tablegen/model/shapes.py"
    tree.edit(
        shapes,
        'SPHERE = SHAPE_CODES["sphere"]\n',
        'SPHERE, OCTAHEDRON = SHAPE_CODES["sphere"], SHAPE_CODES["octahedron"]\n',
    )
    tree.edit(
        shapes,
        "    else:\n        q = 0.2\n",
        "    elif shape == OCTAHEDRON:\n        q = 0.1\n    else:\n        q = 0.2\n",
    )
    tree.edit(
        shapes,
        "        if shape == TRUNCATED_PRISM:\n",
        "        if shape == OCTAHEDRON:\n"
        "            if corner < 6:\n"
        "                axis, side = corner // 2, 1.0 - 2.0 * (corner & 1)\n"
        "                at = side * (axis == 0), b * side * (axis == 1), c * side * (axis == 2)\n"
        "                _store_vertex(vertices, n, at[0], at[1], at[2])\n"
        "                n += 1\n"
        "        elif shape == TRUNCATED_PRISM:\n",
    )


def add_variable(tree):
    """The translational energy after the rebound, over that before."""
    tree.edit(
        "sampler/formats/channels.py", '    "work_shear",\n)', '    "work_shear",\n    "moving",\n)'
    )
    tree.edit(
        "sampler/formats/channels.py",
        '    "omega_x": ("omega_x",),\n',
        '    "moving": ("v", "u_hat", "w_hat"),\n    "omega_x": ("omega_x",),\n',
    )
    tree.edit(
        "tablegen/simulation/scene_variables.py",
        '    if name == "rotational_energy":\n        return simulation.energy[:, 1]\n',
        '    if name == "rotational_energy":\n        return simulation.energy[:, 1]\n'
        '    if name == "moving":\n        return np.square(simulation.state[:, :3]).sum(axis=1)\n',
    )
    tree.edit(
        "sampler/c/src/nodes.h",
        "            state[RBT_COLLISIONS] =",
        "            state[RBT_MOVING] = u[r] * u[r] + v[r] * v[r] + w[r] * w[r];\n"
        "            state[RBT_COLLISIONS] =",
    )
    tree.edit(
        "sampler/c/src/sphere.h",
        "    values[RBT_COLLISIONS] = 1.0;\n",
        "    values[RBT_COLLISIONS] = 1.0;\n"
        "    values[RBT_MOVING] = values[RBT_U] * values[RBT_U] + away * away +\n"
        "                         values[RBT_W] * values[RBT_W];\n",
    )


def add_flag(tree):
    tree.edit(
        "sampler/errors.py",
        '    Code("ERR_MISSING", -1,',
        '    Code("GRAZING", 16, "the impact is flatter than 0.4 rad"),\n'
        '    Code("ERR_MISSING", -1,',
    )
    tree.edit(
        "sampler/c/src/nodes.h",
        "    return rbti_is_outside(alpha1, table->alpha.low, table->alpha.high) * RBT_ANGLE |",
        "    return (alpha1 < 0.4) * RBT_GRAZING |\n"
        "           rbti_is_outside(alpha1, table->alpha.low, table->alpha.high) * RBT_ANGLE |",
    )


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A tree in which all recipes were followed, and the files were made anew once."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    tree = Tree(tmp_path_factory.mktemp("recipes"))
    for add in (add_contact_law, add_shape, add_variable, add_flag):
        add(tree)
    tree.build()
    return tree


@pytest.mark.apart
def test_a_contact_law(tree):
    assert "| 5 | falling |" in (tree.folder / "tables/FORMAT.md").read_text(encoding="utf-8")
    script = """
import math, sampler
from tablegen.config.config import load_config
from tablegen.model.contact_laws import restitution
from tablegen.model.jit import kernel
from tablegen.tables.spheres import sphere_contents
law = {"law": "falling", "coefficient": 0.8, "slowness": 0.01, "valid_speed": [1.0, 200.0]}
pair = {"restitution": law | {"source": "made up"}}
config = load_config("kharaz-2001").with_changes({"pair": pair, "domain": {"speed": [1.0, 200.0]}})
table = sampler.Table(sphere_contents(config))
state = table.sample(math.pi / 2, 100.0, seed=1, index=0)
print(kernel(restitution)(config.pair.kernel_arguments(), 100.0, 1.0), state[1])
"""
    assert [*map(float, tree.run("-c", script).split())] == pytest.approx([0.4, 0.4], rel=1e-12)


@pytest.mark.apart
def test_a_shape(tree):
    header = (tree.folder / "sampler/c/rebound_sampler.h").read_text(encoding="utf-8")
    assert "RBT_SPHERE, RBT_OCTAHEDRON" in header
    script = """
import numpy as np, sampler
from scipy.spatial import ConvexHull
from sampler.formats.shape_codes import SHAPE_CODES
from small_tables import plane
from spin_tables import with_spin_law
from tablegen.config.config import load_config
from tablegen.model.shapes import MAX_VERTICES, inertia, place_vertices
code, b, c, corners = SHAPE_CODES["octahedron"], 0.8, 0.6, np.zeros((MAX_VERTICES, 3))
changes = {"population": {"shapes": {"octahedron": 1.0}}}
population = load_config("corundum-steel").with_changes(changes).population
hull = ConvexHull(corners[: place_vertices(code, b, c, 0.5, corners)[0]])
geometry = population.shape_geometry()[code]
surface = geometry.surface_across * np.sqrt(b * b + c * c + b * b * c * c)
mean = np.mean(inertia(code, b, c, 0.5))
table = sampler.Table(with_spin_law(plane(), codes=(code,)))
keys = {"seed": 1, "index": 0, "hit": 0}
state = table.sample(0.5, 100.0, spin=(0.0, 0.0, 1.0), grain=(code, b, c / b), **keys)
print(hull.volume, geometry.volume * b * c, hull.area, surface)
print(mean, geometry.moment * (1.0 + b * b + c * c))
print(table.grains(1, 0)[0], float(np.isfinite(state).all()))
"""
    numbers = [*map(float, tree.run("-c", script).split())]
    assert numbers[::2] == pytest.approx([*numbers[1:6:2], 5.0], rel=1e-12)
    assert numbers[-1] == 1.0


@pytest.mark.apart
def test_a_variable(tree):
    script = """
import numpy as np, sampler
from small_tables import scene
from tablegen.config.config import load_config
from tablegen.tables.spheres import sphere_contents
names = ["u", "v", "w", "moving"]
config = load_config("kharaz-2001").with_changes({"domain": {"variables": names}})
for contents in (scene(names), sphere_contents(config)):
    table, keys = sampler.Table(contents), {"seed": 1, "index": range(64)}
    states = table.sample(0.5, 70.0, **keys)
    assert table.columns == tuple(names)
    assert (states[:, 3] > 0.0).all()
    np.testing.assert_allclose(states[:, 3], np.square(states[:, :3]).sum(axis=1), rtol=1e-6)
"""
    tree.run("-W", "ignore", "-c", script)


@pytest.mark.apart
def test_a_flag(tree):
    codes = (tree.folder / "sampler/CODES.md").read_text(encoding="utf-8")
    assert "| 16 `RBT_GRAZING` | the impact is flatter than 0.4 rad |" in codes
    script = """
import warnings, numpy as np, sampler
from small_tables import plane
table = sampler.Table(plane())
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    table.sample([0.3, 0.39, 0.5], 70.0, seed=1, index=range(3))
velocity, codes = [[90.0, -30.0, 0.0], [90.0, -60.0, 0.0]], np.zeros(2, np.intc)
keys = {"seed": 1, "index": range(2), "grain": "fresh"}
table.rebound(velocity, (0, 1, 0), 1e-5, **keys, codes=codes)
warned = any(str(w.message).startswith("grazing: the impact is flatter") for w in caught)
print(table.counts["grazing"], *(codes & 16), warned)
"""
    assert tree.run("-c", script).split() == ["3", "16", "0", "True"]
