"""The accuracy that each shipped table states, as README shows it.

    python tools/accuracy_of_tables.py
    python tools/accuracy_of_tables.py --write

The second command writes the table into README.md. Nothing is measured here: the numbers are those
that `tablegen generate` measured when it had made the table, at conditions between its nodes, and
stored in the file. `tablegen validate NAME` measures them again, with other random numbers.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from marked_parts import filled

from sampler.files import available, find_table
from sampler.formats.hdf5 import TableContents, read_table

README = Path(__file__).resolve().parents[1] / "README.md"

#: Heads of the columns, each with the datasets of a file that it shows, and their form.
COLUMNS = {
    "first hit: KS, AUC": {"accuracy/ks": ".3f", "accuracy/auc": ".2f"},
    "own grain without spin: KS, AUC": {"spin_accuracy/ks": ".3f", "spin_accuracy/auc": ".2f"},
    "later hits: KS": {"spin_accuracy/chain_ks": ".3f"},
    "energy": {"spin_accuracy/chain_energy": ".3f"},
    "squared spin": {"spin_accuracy/chain_spin": ".0%"},
    "median angle": {"spin_accuracy/chain_angle": ".0%"},
}


def largest(contents: TableContents, datasets: Mapping[str, str]) -> str:
    """Write the largest values of datasets over all conditions."""
    values = [f"{float(contents[path].max()):{form}}" for path, form in datasets.items()]
    return ", ".join(values).replace("%", " %")


def accuracy_text() -> str:
    """Write the table, a row for each shipped table but those of spheres, which are exact."""
    rows = [f"| {' | '.join(['table', *COLUMNS])} |", "|---" * (len(COLUMNS) + 1) + "|"]
    for name in available(".h5"):
        contents = read_table(find_table(name))
        if not contents.of_spheres:
            cells = [f"`{name}`", *(largest(contents, datasets) for datasets in COLUMNS.values())]
            rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def filled_readme(text: str) -> str:
    """Bring the numbers in README up to date."""
    return filled(text, "README.md", {"accuracy": accuracy_text})


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table, or write it into README."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="write the table into README.md")
    if parser.parse_args(arguments).write:
        README.write_text(filled_readme(README.read_text(encoding="utf-8")), encoding="utf-8")
    print(accuracy_text(), end="")


if __name__ == "__main__":
    main()
