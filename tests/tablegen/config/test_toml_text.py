"""TOML that would end in an error of Python's own, or obey the terminal, is refused in one line."""

import pytest
from pydantic import ValidationError

from sampler.errors import InputError
from tablegen.config.config import load_config, parse_config
from tablegen.config.scenes import MOST_LEVELS, parse_toml

DEEP = 5000
PAIR = load_config("corundum-steel").text


def nested(levels):
    """Tuples in each other."""
    found = ()
    for _ in range(levels):
        found = (found,)
    return found


REFUSED = {
    "lists": ("x = " + "[" * DEEP + "]" * DEEP, "allowed: 20 levels"),
    "tables": ("x = " + "{a = " * DEEP + "1" + "}" * DEEP, "allowed: 20 levels"),
    "dotted key": (".".join(["a"] * DEEP) + " = 1", "allowed: 20 levels"),
    "one level more": ("x = " + "[" * MOST_LEVELS + "]" * MOST_LEVELS, "allowed: 20 levels"),
    "digits": ("seed = 1" + "0" * DEEP, "got an integer of too many digits, allowed: integers of"),
    "hexadecimal digits": ("seed = 0x1" + "0" * DEEP, "got an integer of 20001 bits, allowed: int"),
    "an integer": (f"seed = -1{'0' * 100}", "got an integer of 333 bits, allowed: integers of up"),
    "line in a key": ('[domain]\n"a\\nb" = 1', r"got the key 'a\nb', allowed: up to 100 charac"),
    "escape in a key": ('"a\\u001b[2J" = 1', r"got the key 'a\x1b[2J', allowed"),
    "long key": (f"{'k' * 10**6} = 1", f"got the key '{'k' * 100}', allowed: up to 100 char"),
    "escape in a text": ('name = "a\\u001b[2J"', r"got the text 'a\x1b[2J', allowed: characters"),
    "C1 in a list": ('names = ["a", "\\u009b2J"]', r"got the text '\x9b2J', allowed: characters"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_reason(case):
    text, reason = REFUSED[case]
    for read in (parse_toml, parse_config):
        with pytest.raises(InputError) as caught:
            read(text, "my.toml")
        line = str(caught.value)
        assert line.startswith("my.toml: ")
        assert reason in line
        assert line.isprintable()
        assert len(line) < 300


CHANGES = {
    "integer": (
        {"table": {"seed": 10**5000}},
        "got an integer of 16610 bits, allowed: integers of",
    ),
    "tuples": ({"table": {"speed_nodes": nested(DEEP)}}, "allowed: 20 levels"),
    "key": ({"domain": {"a\nb": 1}}, r"got the key 'a\nb', allowed"),
}


@pytest.mark.parametrize("case", CHANGES)
def test_changes_from_python(case):
    changes, reason = CHANGES[case]
    with pytest.raises(InputError) as caught:
        load_config("corundum-steel").with_changes(changes)
    line = str(caught.value)
    assert line.startswith("corundum-steel, changed: ")
    assert reason in line
    assert line.isprintable()


def test_no_record_has_text_that_a_terminal_obeys():
    law = load_config("corundum-steel").pair.restitution
    with pytest.raises(ValidationError, match="text that is not blank and can be shown"):
        type(law).model_validate(law.model_dump() | {"source": "a\x1b[2J"})


def test_what_is_allowed():
    innermost = "[" * (MOST_LEVELS - 2) + "]" * (MOST_LEVELS - 2)
    text = f'"a b" = "lines\\nand\\ttabs"\nx = {innermost}\nseed = 1{"0" * 99}\n'
    tree = parse_toml(text, "my.toml")
    assert (tree["a b"], tree["seed"]) == ("lines\nand\ttabs", 10**99)


@pytest.mark.parametrize(
    ("change", "beginning"),
    [
        (('name = "corundum-steel"', f'name = "{"x" * 10**6}"'), "name: got 'xxx"),
        (('particle = "', 'particle = "a\\nb'), r"pair.particle: got 'a\nb"),
        (('wall = "', f'wall = "{"x" * 300}'), "pair.wall: got 'xxx"),
    ],
)
def test_names_and_numbers_of_a_pair(change, beginning):
    assert change[0] in PAIR
    with pytest.raises(InputError) as caught:
        parse_config(PAIR.replace(*change, 1), "my.toml")
    line = str(caught.value).removeprefix("my.toml: ")
    assert line.startswith(beginning)
    assert line.isprintable()
    assert len(line) < 300


@pytest.mark.parametrize("name", ["a\\nb", "\\u202eb.toml", "a\\u009b.toml"])
def test_names_of_files_are_lines(name, tmp_path):
    for text, field in (
        (f'name = "a"\npair = "{name}"\n', "pair: got "),
        (f'[[population.meshes]]\nfile = "{name}"\n', "population.meshes[0].file: got "),
    ):
        with pytest.raises(InputError) as caught:
            parse_config(text, "my.toml", tmp_path)
        line = str(caught.value)
        assert field in line or "got the text" in line
        assert line.isprintable()


@pytest.mark.parametrize(
    "accuracy",
    ["ks = 1e-300", "ks = 1e-9", "sliced_wasserstein = 1e-300", "correlation_error = 5e-324"],
)
def test_accuracies_that_no_sample_can_show(accuracy):
    with pytest.raises(InputError, match=r"accuracy\.\w+: got .*, allowed: greater than or equal"):
        parse_config(f'name = "a"\npair = "corundum-steel"\n[accuracy]\n{accuracy}\n', "my.toml")
