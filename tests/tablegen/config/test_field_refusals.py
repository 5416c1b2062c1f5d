"""One clear line for every field that cannot be used: which, what was given, what is allowed."""

import tomllib

import pytest
from contact_law_samples import RESISTANCE, RESTITUTION, SOURCE

from sampler.errors import InputError
from sampler.formats.channels import VARIABLES
from tablegen.config.config import load_config, parse_config
from tablegen.config.mesh import MOST_VERTICES

#: What replaces the shipped pair's fields => how the line begins ... a bound that it states.
FIELDS = """
domain.alpha_deg = [0.0, 90.0] => domain.alpha_deg[0]: got 0, ... 0
domain.alpha_deg = [0.5, 91.0] => domain.alpha_deg[1]: got 91, ... 90
domain.alpha_deg = [0.5, 90.00000000000001] => domain.alpha_deg[1]: got 90.00000000000001, ... 90
domain.alpha_deg = [60.0, 20.0] => domain.alpha_deg: got [60, 20], ... low <= high
domain.alpha_deg = [45.0] => domain.alpha_deg: got [45], ... 2
domain.alpha_deg = [20, 40, 60] => domain.alpha_deg: got [20, 40, 60], ... 2
domain.speed = 100.0 => domain.speed: got 100, ... array
domain.speed = [nan, 300] => domain.speed[0]: got nan, ... a finite number
domain.speed = [50, inf] => domain.speed[1]: got inf, ... a finite number
domain.speed = [-50.0, 300.0] => domain.speed[0]: got -50, ... 0
domain.speed = [50.0, 2e5] => domain.speed[1]: got 200000, ... 100000
domain.speed = ["50", 300] => domain.speed[0]: got '50', ... number
domain.extrapolate = 1 => domain.extrapolate: got 1, ... boolean
domain.sped = [50.0, 300.0] => domain.sped: unknown field, ... alpha_deg, speed, extrapolate
domain.dimension = 1 => domain.dimension: got 1, ... 2 or 3
domain.dimension = true => domain.dimension: got true, ... 2 or 3
domain.dimension = "2" => domain.dimension: got '2', ... 2 or 3
domain.components = [] => domain.components: got [], ... 1
domain.components = ["u", "q"] => domain.components[1]: got 'q', ... {SOME}
domain.components = ["U"] => domain.components[0]: got 'U', ... {SOME}
domain.components = [1] => domain.components[0]: got 1, ... string
domain.components = [["u"]] => domain.components[0]: got ['u'], ... string
domain.components = "u" => domain.components: got 'u', ... array
domain.components = true => domain.components: got true, ... array
domain.components = ["u", "u"] => domain.components: got ['u', 'u'], ... each name once
domain.components = [{SOME_QUOTED}] => domain.components: got ['u', ... up to 8 names
domain.components = ["omega_x", "omega_y", "omega_z", "collisions", "work_shear"] => \
domain.components: got ['omega_x', ... with work_normal or work_shear no collisions
domain = {dimension = 2, components = ["u", "w"]} => domain.components: got ['u', 'w'], ... out w in
domain = {dimension = 2, components = ["omega_x"]} => domain.components: ... flow (dimension = 2)
scene = {} => scene: unknown field, ... spin, domain, model, table, accuracy, spin_accuracy
name = "a/b" => name: got 'a/b', ... letters, digits
name = "" => name: got '', ... letters, digits
name = 2026-01-01 => name: got ['2026-01-01'], ... string
pair.wall = "  " => pair.wall: got '  ', ... not blank
pair.wall = 3 => pair.wall: got 3, ... string
pair.resistance = "none" => pair.resistance: got 'none', ... object
pair.restitution.coefficient = true => pair.restitution.coefficient: got true, ... number
pair.restitution.coefficient = 0.0 => pair.restitution.coefficient: got 0, ... 0
pair.restitution.exponent = 10.5 => pair.restitution.exponent: got 10.5, ... 10
pair.resistance.strength = -10.1 => pair.resistance.strength: got -10.1, ... -10
population.shapes.cube = 1.0 => population.shapes.cube: unknown field, ... ellipsoid, prism, trunc
population.shapes.truncated-prism = -1 => population.shapes.truncated-prism: got -1, ... 0
population.truncation = 1.0 => population.truncation: got 1, ... 1
population.aspect.distribution = "even" => population.aspect.distribution: got 'even', ... 'fixed'
population.aspect = {distribution = "fixed"} => population.aspect.values: missing, ... a value
population.aspect.range = [0.0, 1.0] => population.aspect.range[0]: got 0, ... 0
population.aspect.range = [9.0, 9.5] => population.aspect.range[0]: got 9, ... 1
population.aspect = {mean = 9.0} => population.aspect.range: got [0.5, 1], ... 1e-06 of the
population.meshes = 3 => population.meshes: got 3, ... array
population.meshes = [{file = "none.stl"}] => population.meshes[0].file: got none.stl, ... exists
population.meshes = [{weight = 1}] => population.meshes[0].vertices: missing, ... a value
population.meshes = [{fiel = "a"}] => population.meshes[0].fiel: unknown field, ... file, vertices
population.meshes = [{vertices = 3}] => population.meshes[0].vertices: got 3, ... array
population.meshes = [{vertices = [[0, 0]]}] => population.meshes[0].vertices[0]: got [0, 0], ... 3
population.meshes = [{vertices = [[0, 0, "a"]]}] => population.meshes[0].vertices[0][2]: ... number
population.meshes = [{vertices = [[0, 0, 0]]}] => population.meshes[0].vertices: got [[0 ... {MOST}
population.meshes = [{vertices = [], weight = -1}] => population.meshes[0].v ... weight: got -1
model.contact_resolution = 0.2 => model.contact_resolution: got 0.2, ... 0.1
model.tolerance = 0 => model.tolerance: got 0, ... 0.00000000000001
table.seed = 1.0 => table.seed: got 1.0, ... integer
table.components = 4097 => table.components: got 4097, ... 4096
table.quantile_knots = 256 => table.quantile_knots: got 256, ... odd
table.quantile_knots = 15 => table.quantile_knots: got 15, ... 17
table.speed_nodes = [] => table.speed_nodes: got [], ... 1
table.speed_nodes = [5, 5, 300] => table.speed_nodes: got [5, 5, 300], ... each larger
table.speed_nodes = [60, 300] => table.speed_nodes: got [60, 300], ... domain.speed, [5, 300]
table.alpha_nodes_deg = [0.5, 89] => table.alpha_nodes_deg: got [0.5, 89], ... alpha_deg, [0.5, 90]
accuracy.auc = 0.4 => accuracy.auc: got 0.4, ... 0.5
accuracy.ks = 0.0 => accuracy.ks: got 0, ... 0
accuracy.preset = "perfect" => accuracy.preset: got 'perfect', ... 'standard'
"""

#: The same of a law: what replaces the fields of the sample of that kind.
RESTITUTIONS = """
constant: law = "elastic" => law: got 'elastic', ... 'polynomial', 'constant', 'power', 'tabulated'
constant: value = 1.01 => value: got 1.01, ... 1
constant: valeu = 0.5 => valeu: unknown field, ... law, value, valid_speed, source
constant: source = " " => source: got ' ', ... not blank
constant: valid_speed = 100.0 => valid_speed: got 100, ... array
polynomial: coefficients = [1.0, 0.1, -0.5] => coefficients: got [1, 0.1, -0.5], ... -0.07662 at 90
polynomial: coefficients = [0.9, 0.4, -0.2] => coefficients: got [0.9, 0.4, -0.2], ... 1.1 at 57.3
polynomial: coefficients = [] => coefficients: got [], ... 1
polynomial: coefficients = [0.9, nan] => coefficients[1]: got nan, ... a finite number
polynomial: coefficients = 0.9 => coefficients: got 0.9, ... array
power: exponent = -0.25 => exponent: got -0.25, ... 0
power: reference_speed = 0.0 => reference_speed: got 0, ... 0
tabulated: value = [[0.9, 0.8], [0.6, 0.5], [0.4, 1.2]] => value[2][1]: got 1.2, ... 1
tabulated: value = [[0.9, 0.8], [0.6, 0.5]] => value: got [[0.9, 0.8], [0.6, 0.5]], ... 3 rows
tabulated: value = [[0.9, 0.8], [0.6, 0.5], [0.4]] => value: got [[0.9, ... 3 rows (angle_deg) of 2
tabulated: value = [0.9, 0.6, 0.4] => value[0]: got 0.9, ... array
tabulated: value = [[0.9, "a"], [0.6, 0.5], [0.4, 0.2]] => value[0][1]: got 'a', ... number
tabulated: angle_deg = [10.0, 45.0, 90.5] => angle_deg[2]: got 90.5, ... 90
tabulated: angle_deg = [10.0, 90.0, 45.0] => angle_deg: got [10, 90, 45], ... each larger
tabulated: speed = [0.0, 100.0] => speed[0]: got 0, ... 0
"""
RESISTANCES = """
constant: law = "viscous" => law: got 'viscous', ... 'exponential-orientation', 'constant'
constant: value = -0.1 => value: got -0.1, ... 0
orientation: factor = 101.0 => factor: got 101, ... 100
"""


def cases(text):
    """Changes, how the line begins, and a bound, from every line of a list."""
    text = text.replace("{SOME_QUOTED}", ", ".join(map(repr, VARIABLES)))
    text = text.replace("{SOME}", ", ".join(VARIABLES)).replace("{MOST}", f"4 to {MOST_VERTICES}")
    rows = (line.partition(" => ") for line in text.strip().splitlines())
    return [(toml, *rest.split(" ... ")) for toml, _, rest in rows]


def refused(changes):
    """The one line with which a changed shipped pair is refused."""
    with pytest.raises(InputError) as caught:
        load_config("corundum-steel").with_changes(changes)
    line = str(caught.value)
    assert "\n" not in line
    return line.removeprefix("corundum-steel, changed: ")


def check(line, beginning, bound):
    assert len(line) < 300
    assert line.startswith(beginning)
    assert bound in line.partition("allowed")[2]


@pytest.mark.parametrize(("toml", "beginning", "bound"), cases(FIELDS))
def test_field_value_and_bound_are_named(toml, beginning, bound):
    check(refused(tomllib.loads(toml)), beginning, bound)


LAWS = [("restitution", RESTITUTION, *case) for case in cases(RESTITUTIONS)]
LAWS += [("resistance", RESISTANCE, *case) for case in cases(RESISTANCES)]


@pytest.mark.parametrize(("kind", "samples", "toml", "beginning", "bound"), LAWS)
def test_field_of_a_law_its_value_and_bound_are_named(kind, samples, toml, beginning, bound):
    name, _, change = toml.partition(": ")
    law = SOURCE | samples[name] | tomllib.loads(change)
    check(refused({"pair": {kind: law}}), f"pair.{kind}.{beginning}", bound)


def test_long_values_are_cut():
    law = SOURCE | {"law": "polynomial", "coefficients": [0.1] * 17}
    line = refused({"pair": {"restitution": law}})
    check(line, "pair.restitution.coefficients: got [0.1, 0.1, 0.1, ", "16")
    check(refused({"name": "x y" * 1000}), "name: got 'x yx y", "letters, digits")
    check(refused({"table": {"seed": 2**64}}), f"table.seed: got {2**64}", f"{2**64 - 1}")


def test_some_particle_must_have_a_weight():
    shapes = load_config("corundum-steel").population.shapes.model_dump(by_alias=True)
    line = refused({"population": {"shapes": dict.fromkeys(shapes, 0)}})
    check(line, "population.shapes: got [0, 0, 0, 0, 0], ", "a weight above 0")


def test_several_problems_are_all_named():
    line = refused({"model": {"tolerance": 1.0}, "accuracy": {"auc": 2.0, "ks": 3.0}})
    parts = line.split("; ")
    assert [part.partition(",")[0] for part in parts] == [
        "model.tolerance: got 1",
        "accuracy.ks: got 3",
        "accuracy.auc: got 2",
    ]


def test_misspelt_field_is_named_before_the_missing_one():
    law = {"law": "power", "coefficient": 0.5, "exponent": 0.2, "referense_speed": 1.0, **SOURCE}
    assert refused({"pair": {"restitution": law}}) == (
        "pair.restitution.referense_speed: unknown field, allowed here: law, coefficient, "
        "reference_speed, exponent, valid_speed, source; "
        "pair.restitution.reference_speed: missing, allowed: a value"
    )


def test_law_without_a_name_is_told_the_names():
    text = load_config("corundum-steel").text.replace('law = "exponential"\n', "")
    with pytest.raises(
        InputError, match=r"pair\.restitution\.law: missing, .*'exponential', 'poly"
    ):
        parse_config(text, "my.toml")


def test_more_problems_than_one_reads_are_counted():
    weights = {"ellipsoid": -1.0, "prism": -1.0, "truncated-prism": -1.0, "tetrahedron": -1.0}
    numbers = {"ks": 2.0, "auc": 2.0, "correlation_error": 3.0}
    line = refused({"population": {"shapes": weights}, "accuracy": numbers})
    assert line.count("; ") == 6
    assert line.endswith("; and 1 more problem")


def test_the_same_problem_is_named_once():
    """Two numbers are missing of one list, which is one thing to mend."""
    line = refused({"population": {"aspect": {"distribution": "fixed", "values": []}}})
    assert line == "population.aspect.values: got [], allowed: at least 2 items"
