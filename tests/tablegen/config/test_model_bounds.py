"""Bounds of the direct model: the same in files, flags and functions, and one line beyond them."""

import math
import re

import numpy as np
import pytest
from documents import ROOT

from sampler.errors import InputError
from tablegen.config.config import load_config
from tablegen.config.mesh import mesh_particle, read_mesh
from tablegen.model import model_bounds as bounds
from tablegen.simulation.simulate import make_condition, simulate_condition

CONFIG = load_config("corundum-steel")

#: What every call of the program needs.
USUAL = {"--pair": "corundum-steel", "--shape": "prism", "--alpha": 45, "--speed": 200}
USUAL |= {"--count": 10, "--seed": 1}

#: Flags of `tablegen simulate` that were taken once and gave NaN, or no end, and what is said now.
FLAGS = [
    ({"--aspect": (1e-200, 1)}, "'--aspect': got '1e-200', allowed: 0.001 to 1"),
    ({"--aspect": (1e-5, 1)}, "'--aspect': got '1e-05', allowed: 0.001 to 1"),
    ({"--aspect": (1e-6, 1e-6)}, "'--aspect': got '1e-06', allowed: 0.001 to 1"),
    ({"--spin": (1e100, 0, 0)}, "'--spin': got '1e+100', allowed: -1000 to 1000 V/a"),
    ({"--spin": (0, 1e6, 0)}, "'--spin': got '1000000.0', allowed: -1000 to 1000 V/a"),
    ({"--alpha": 1e-100}, "'--alpha': got '1e-100', allowed: 1e-06 to 90 degrees"),
    ({"--alpha": 1e-20}, "'--alpha': got '1e-20', allowed: 1e-06 to 90 degrees"),
    ({"--speed": 1e-300}, "'--speed': got '1e-300', allowed: 1e-06 to 100000 m/s"),
    (
        {"--spin": (900, 0, 0), "--alpha": 0.01},
        "spin: got 900 V/a at 0.01 degrees, allowed there: up to 87.2665 V/a, 1,000,000 radians",
    ),
]

#: The same in a configuration.
FIELDS = [
    (
        {"population": {"aspect": {"distribution": "fixed", "values": [1e-160, 1.0]}}},
        "population.aspect.values[0]: got 1e-160, allowed: greater than or equal to 0.001",
    ),
    (
        {"population": {"aspect": {"range": [1e-4, 1.0]}}},
        "population.aspect.range[0]: got 0.0001, allowed: greater than or equal to 0.001",
    ),
    (
        {"domain": {"alpha_deg": [1e-7, 90.0]}},
        "domain.alpha_deg[0]: got 1e-07, allowed: greater than or equal to 0.000001",
    ),
    (
        {"model": {"contact_resolution": 1e-300}},
        "model.contact_resolution: got 1e-300, allowed: greater than or equal to 0.000001",
    ),
]


@pytest.mark.parametrize(("flags", "line"), FLAGS)
def test_flags_beyond_them_are_refused(refuse, tmp_path, flags, line):
    words = []
    for name, values in (USUAL | flags).items():
        words += [name, *(values if isinstance(values, tuple) else (values,))]
    told = refuse("tablegen", "simulate", *words, "--output", tmp_path / "x.npz")
    assert line in told


@pytest.mark.parametrize(("changes", "line"), FIELDS)
def test_fields_beyond_them_are_refused(changes, line):
    with pytest.raises(InputError) as caught:
        CONFIG.with_changes(changes)
    assert line in str(caught.value)


@pytest.mark.parametrize("scale", [1e-300, 1e-40, 1e40, 1e300])
def test_meshes_of_sizes_beyond_them_are_refused(tmp_path, scale):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * scale
    allowed = "coordinates up to 1e+30, a largest extent of 1e-30 or more"
    with pytest.raises(InputError, match=re.escape(allowed)):
        mesh_particle(corners)
    path = tmp_path / "grain.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    path.write_text("\n".join([*lines, "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4", ""]))
    with pytest.raises(InputError, match=re.escape(allowed)):
        read_mesh(path)


@pytest.mark.parametrize("scale", [1e-29, 1e29])
def test_meshes_of_sizes_within_them_are_the_same_particle(scale):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    made, plain = mesh_particle(corners * scale), mesh_particle(corners)
    np.testing.assert_allclose(made.moments, plain.moments, rtol=1e-12)


def test_spin_is_bounded_by_what_a_particle_turns_before_it_meets_the_wall():
    alpha1 = np.radians(0.01)
    most = 0.5 * bounds.MOST_TURNED * math.sin(alpha1)
    assert make_condition(alpha1, 200.0, (0.0, 0.999 * most, 0.0)).tolerance > 0.0
    with pytest.raises(InputError, match=r"^spin: got .* V/a at 0\.01 degrees, allowed there"):
        make_condition(alpha1, 200.0, (0.0, 1.001 * most, 0.0))


def test_the_table_of_bounds_is_that_of_the_code():
    page = (ROOT / "tables" / "LAWS.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| ([^|]+?) \| ([^|]+?) \|", page.partition("## Bounds")[2], re.M))
    assert rows["aspect ratios b/a, c/b"] == bounds.ASPECT.words
    assert rows["impact angle"] == bounds.ALPHA_DEG.words
    assert rows["impact speed"] == bounds.SPEED.words
    assert rows["each component of the spin before the impact"] == bounds.SPIN.words
    turned = f"up to {0.5 * bounds.MOST_TURNED:,.0f} sin(angle) V/a"
    assert rows["size of that spin"] == turned
    assert rows["`contact_resolution`"] == bounds.CONTACT_RESOLUTION.words
    assert rows["`tolerance`"] == bounds.TOLERANCE.words
    low, high = bounds.MESH_SIZE.low, bounds.MESH_SIZE.high
    assert rows["mesh"] == f"coordinates up to {high:g}, extent of at least {low:g}"


#: Corners with the cost of a particle at default numerics far below a second.
CORNERS = [
    ("prism", (1e-3, 1e-3), 1e-6, 1e-6, (0.0, 0.0, 0.0)),
    ("truncated-prism", (1e-3, 1.0), 90.0, 1e5, (0.0, 0.0, 1e3)),
    ("tetrahedron", (1.0, 1e-3), 45.0, 1e5, (1e3, 0.0, 0.0)),
    ("ellipsoid", (1e-3, 1.0), 1e-6, 1e5, (0.0, 0.0, -1e-4)),
]


@pytest.mark.parametrize(("shape", "aspect", "alpha_deg", "speed", "spin"), CORNERS)
def test_corners_of_the_bounds_give_finite_states(shape, aspect, alpha_deg, speed, spin):
    population = CONFIG.population.restricted_to(shape).with_aspect(*aspect)
    condition = make_condition(np.radians(alpha_deg), speed, spin)
    made = simulate_condition(CONFIG.pair, population, condition, 8, seed=5, threads=1)
    assert np.isfinite(made.state).all()
    assert made.state[:, 1].min() > 0.0
    assert made.energy.sum(axis=1).max() <= 1.0 + 1e-9
