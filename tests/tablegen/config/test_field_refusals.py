"""Every field with a bad value gives one line with its name, the value and what is allowed."""

import tomllib

import pytest
from contact_law_samples import RESISTANCE, RESTITUTION, SOURCE

from sampler.errors import InputError
from tablegen.config.config import load_config, parse_config

#: Changes of the shipped pair => beginning of the line ... a bound that it states.
FIELDS = """
domain.alpha_deg = [1e-7, 90.0] => domain.alpha_deg[0]: got 1e-07, ... 1e-06 or more
domain.alpha_deg = [60.0, 20.0] => domain.alpha_deg: got [60, 20], ... low <= high
domain.alpha_deg = [20, 40, 60] => domain.alpha_deg: got [20, 40, 60], ... 2
domain.speed = [nan, 300] => domain.speed[0]: got nan, ... a finite number
domain.sped = [50.0, 300.0] => domain.sped: unknown field, ... alpha_deg, speed, extrapolate
domain.variables = ["u", "q"] => domain.variables: got ['u', 'q'], ... each once, of u, v, w
domain.variables = ["omega_x", "omega_y", "omega_z", "collisions", "work_shear"] => \
domain.variables: got ['omega_x', ... with work_normal or work_shear no collisions
domain = {dimension = 2, variables = ["u", "w"]} => domain.variables: got ['u', 'w'], ... out w in
domain.variables = ["u", "collisions"] => spin: got true, ... false with collisions among
name = "a/b" => name: got 'a/b', ... letters, digits
pair.wall = "  " => pair.wall: got '  ', ... not blank
pair.resistance = "none" => pair.resistance: got 'none', ... a table
population.aspect.distribution = "even" => population.aspect.distribution: got 'even', ... 'fixed'
population.aspect = {distribution = "fixed"} => population.aspect.values: is missing, ... a value
population.aspect = {mean = 9.0} => population.aspect.range: got [0.5, 1], ... (probability 1e-06)
population.meshes = [{file = "none.stl"}] => population.meshes[0].file: there is no file none.stl
population.meshes = [{vertices = [[0, 0, 0]]}] => population.meshes[0].vertices: got [[0 ... or more
table.seed = 1.0 => table.seed: got 1.0, ... integer
table.spin_groups = 1 => table.spin_groups: got 1, ... 2
table.quantile_knots = 256 => table.quantile_knots: got 256, ... odd
table.speed_nodes = [5, 5, 300] => table.speed_nodes: got [5, 5, 300], ... each larger
table.speed_nodes = [60, 300] => table.speed_nodes: got [60, 300], ... domain.speed, [5, 300]
"""

#: The same for a law: changes of the sample of that kind.
RESTITUTIONS = """
constant: law = "elastic" => law: got 'elastic', ... 'polynomial', 'constant', 'power', 'tabulated'
constant: valeu = 0.5 => valeu: unknown field, ... law, value, valid_speed, source
polynomial: coefficients = [1.0, 0.1, -0.5] => coefficients: got [1, 0.1, -0.5], ... -0.07662 at 90
power: exponent = -0.25 => exponent: got -0.25, ... 0
tabulated: value = [[0.9, 0.8], [0.6, 0.5], [0.4, 1.2]] => value[2][1]: got 1.2, ... 1
tabulated: value = [[0.9, 0.8], [0.6, 0.5], [0.4]] => value: got [[0.9, ... 3 rows (angle_deg) of 2
tabulated: angle_deg = [10.0, 90.0, 45.0] => angle_deg: got [10, 90, 45], ... each larger
"""
RESISTANCES = """
coulomb: dynamic = 0.5 => dynamic: got 0.5, ... 0 to static, 0.4
coulomb: tangential_restitution = [0.1, 0.2] => tangential_restitution: got [0.1, ... one number
tabulated: value = [0.9] => value: got [0.9], ... 2 numbers, one for each of angle_deg
"""


def cases(text):
    """Return change, beginning of the line, and bound of each line of a list."""
    rows = (line.partition(" => ") for line in text.strip().splitlines())
    return [(toml, *rest.split(" ... ")) for toml, _, rest in rows]


def refused(changes):
    with pytest.raises(InputError) as caught:
        load_config("corundum-steel").with_changes(changes)
    line = str(caught.value)
    assert "\n" not in line
    return line.removeprefix("corundum-steel, changed: ")


def check(line, beginning, *bound):
    """A bound is a part of the line; a line without a bound must be equal."""
    assert len(line) < 300
    assert line.startswith(beginning)
    assert bound[0] in line.partition("allowed")[2] if bound else line == beginning


@pytest.mark.parametrize(("toml", "line"), [(toml, line) for toml, *line in cases(FIELDS)])
def test_field_value_and_bound_are_named(toml, line):
    check(refused(tomllib.loads(toml)), *line)


LAWS = [("restitution", RESTITUTION, *case) for case in cases(RESTITUTIONS)]
LAWS += [("resistance", RESISTANCE, *case) for case in cases(RESISTANCES)]


@pytest.mark.parametrize(("kind", "samples", "toml", "beginning", "bound"), LAWS)
def test_field_of_a_law_its_value_and_bound_are_named(kind, samples, toml, beginning, bound):
    name, _, change = toml.partition(": ")
    law = SOURCE | samples[name] | tomllib.loads(change)
    check(refused({"pair": {kind: law}}), f"pair.{kind}.{beginning}", bound)


def test_misspelt_field_is_named_before_the_missing_one_and_others_follow():
    law = {"law": "power", "coefficient": 0.5, "exponent": 0.2, "referense_speed": 1.0, **SOURCE}
    line = refused({"pair": {"restitution": law}, "accuracy": {"auc": 2.0}})
    assert [part.partition(": ")[0] for part in line.split("; ")] == [
        "pair.restitution.referense_speed",
        "pair.restitution.reference_speed",
        "accuracy.auc",
    ]


def test_law_without_a_name_is_told_the_names():
    text = load_config("corundum-steel").text.replace('law = "exponential"\n', "")
    with pytest.raises(InputError, match=r"restitution\.law: is missing, .*'exponential', 'poly"):
        parse_config(text, "my.toml")
