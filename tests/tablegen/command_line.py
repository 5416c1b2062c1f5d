"""Words of command lines for tests."""

from tiny_tables import ROUGH

DONE, MISSED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

#: A simulation that can be done.
SIMULATE = {
    "--pair": "corundum-steel",
    "--shape": "mixture",
    "--alpha": 45,
    "--speed": 200,
    "--count": 300,
    "--seed": 1,
}


def flags(options, changes):
    """Return the words of options, with changes; None removes an option."""
    words = []
    for name, value in (options | changes).items():
        if value is not None:
            words += [name, *(value if isinstance(value, tuple) else (value,))]
    return words


def config_file(folder, config=ROUGH, **changes):
    """Write a configuration with some changes to a file."""
    path = folder / "my.toml"
    path.write_text(config.with_changes(changes).text)
    return path
