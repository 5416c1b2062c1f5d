"""Files of a configuration: the text of one, and which others it is read from."""

from pathlib import Path
from typing import Any, TypeGuard

from sampler.errors import InputError
from sampler.files import find_config, find_file, read_file
from tablegen.config.toml_text import parse_toml

#: Most bytes of a configuration file, whose reading takes seconds then.
_MOST_BYTES = 2**24


def read_text(path: Path) -> str:
    """Text of a file; a byte-order mark, which some editors write, is dropped.

    Raises
    ------
    InputError
        If it cannot be read, is too large or is not UTF-8.
    """
    try:
        return read_file("configuration", path, _MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path.name}: got byte {error.object[error.start]:#04x} at position {error.start}, "
            "allowed: UTF-8 text"
        ) from error


def pair_file(reference: str, origin: str, directory: Path) -> Path:
    """Find the pair file that a scene refers to.

    Parameters
    ----------
    reference : str
        A name, or a path.
    origin : str
        Name of the scene, to open an error message.
    directory : Path
        Folder to which a path is relative.

    Raises
    ------
    InputError
        If there is no such file or name.
    """
    is_path = reference.endswith(".toml") or len(Path(reference).parts) > 1
    try:
        return find_file("pair", directory / reference if is_path else reference, ".toml")
    except InputError as error:
        raise InputError(f"{origin}: {error}") from error


def names_a_file(mesh: object) -> TypeGuard[dict[str, Any]]:
    """Whether an entry of a mesh has a file to be read, and not the vertices themselves."""
    return isinstance(mesh, dict) and "vertices" not in mesh and isinstance(mesh.get("file"), str)


def config_files(name_or_path: str | Path) -> list[Path]:
    """Files that a configuration is read from: its own, that of the pair it names, and meshes.

    Nothing is checked: what cannot be read is left out.

    Parameters
    ----------
    name_or_path : str or Path
        As for `tablegen.config.config.load_config`.
    """
    try:
        path = find_config(name_or_path)
        tree = parse_toml(read_text(path), path.name)
    except InputError:
        return []
    files = [path, *_mesh_files(tree, path.parent)]
    if isinstance(tree.get("pair"), str):
        try:
            base = pair_file(tree["pair"], path.name, path.parent)
            files += [base, *_mesh_files(parse_toml(read_text(base), base.name), base.parent)]
        except InputError:
            pass
    return files


def _mesh_files(tree: dict[str, Any], directory: Path) -> list[Path]:
    population = tree.get("population")
    meshes = population.get("meshes") if isinstance(population, dict) else None
    entries = meshes if isinstance(meshes, list) else []
    return [directory / mesh["file"] for mesh in entries if names_a_file(mesh)]
