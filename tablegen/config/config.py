"""Configurations of tables, read from TOML and checked.

A *pair file* has the material pair, the population, the domain, and how a table is made. A *scene*
names a pair file in a top-level ``pair = "..."`` and changes some fields.
"""

import logging
import tomllib
from pathlib import Path
from typing import Annotated, Literal, Self

import tomli_w
from pydantic import AfterValidator, Field, PrivateAttr, ValidationError, model_validator

from sampler.errors import InputError
from sampler.files import find_config, find_file, read_file
from sampler.formats.bounds import GROUP_SIZE, N_GROUPS
from sampler.formats.channels import STATE, VARIABLES, WORKS
from tablegen.config.complaints import MISSING, complaint, refusal, shown
from tablegen.config.field_types import (
    AngleRange,
    Increasing,
    Name,
    Record,
    SpeedRange,
    VariableNames,
)
from tablegen.config.grains import GRAINS, named_population
from tablegen.config.metric_table import CHAIN_LIMITS
from tablegen.config.pairs import MaterialPair
from tablegen.config.population import Population
from tablegen.config.scenes import Tree, merged, parse_toml
from tablegen.config.targets import AccuracyTargets, SpinTargets
from tablegen.meshes.mesh_file import read_mesh
from tablegen.model.model_bounds import CONTACT_RESOLUTION, TOLERANCE


def _odd(value: int | None) -> int | None:
    # with an even number of knots the median would be between two of them
    if value is not None and value % 2 == 0:
        raise ValueError("an odd number")
    return value


_LOG = logging.getLogger("tablegen")

#: Variables of a plane flow, and the variables that it does not use.
PLANE = ("u", "v", "omega_z")
_OUT_OF_PLANE = ("w", "omega_x", "omega_y")

#: A largest angle of fewer degrees than this was probably given in radians.
_LIKE_RADIANS = 2.0


class Domain(Record):
    """Impact angles (degrees from the wall) and speeds (m/s) that a table covers."""

    alpha_deg: AngleRange
    speed: SpeedRange
    #: Whether speeds outside the range in which the restitution law was measured are allowed.
    extrapolate: bool = False
    #: 2 for a plane flow, without w, omega_x and omega_y.
    dimension: Literal[2, 3] = 3
    #: Variables of a draw. By default u, v, w, omega_x, omega_y, omega_z, or `PLANE` in a plane
    #: flow.
    variables: VariableNames | None = None

    @model_validator(mode="after")
    def _plane(self) -> Self:
        extra = [name for name in self.columns if self.dimension == 2 and name in _OUT_OF_PLANE]
        if extra:
            allowed = f"without {', '.join(extra)} in a plane flow (dimension = 2)"
            raise refusal("variables", self.variables, allowed)
        return self

    @property
    def columns(self) -> tuple[str, ...]:
        """Variables of a draw, in the order of `sampler.formats.channels.VARIABLES`."""
        if self.variables is not None:
            return tuple(name for name in VARIABLES if name in self.variables)
        return PLANE if self.dimension == 2 else STATE


class ModelSettings(Record):
    """Numerical parameters of the direct model."""

    #: Smallest rebound speed of a contact point over the impact speed, which ends sustained
    #: contact.
    contact_resolution: Annotated[float, Field(**CONTACT_RESOLUTION.field)] = 1e-3
    #: Truncation error of the free rotation between collisions.
    tolerance: Annotated[float, Field(**TOLERANCE.field)] = 1e-10


class TableSettings(Record):
    """How a table is made. The generator chooses the fields that are not given."""

    seed: Annotated[int, Field(ge=0, le=2**64 - 1)] = 1
    samples_per_node: Annotated[int | None, Field(ge=100, le=10**9)] = None
    alpha_nodes_deg: Increasing[float] | None = None
    speed_nodes: Increasing[float] | None = None
    #: Components of the mixture that carries the dependence.
    components: Annotated[int | None, Field(ge=1, le=4096)] = None
    quantile_knots: Annotated[int | None, Field(ge=17, le=65535), AfterValidator(_odd)] = None
    #: Spin law: leaves in the tree of a shape, groups of experts in a leaf, experts in a group, and
    #: simulated rebounds in a leaf.
    spin_leaves: Annotated[int | None, Field(ge=1, le=1024)] = None
    spin_groups: Annotated[int | None, Field(ge=2, le=N_GROUPS)] = None
    spin_experts: Annotated[int | None, Field(ge=1, le=GROUP_SIZE)] = None
    spin_rebounds: Annotated[int | None, Field(ge=1000, le=10**8)] = None


class Config(Record):
    """A complete, checked configuration of a table, or of a direct simulation.

    A configuration is read by `load_config` or `parse_config`, and never modified. `with_changes`
    makes another one.

    Attributes
    ----------
    name : str
        Name of the pair file or scene.
    pair : MaterialPair
        Particle material, wall material, and the laws of their contact.
    population : Population
        Shapes and meshes with their weights, and the law of the aspect ratios.
    spin : bool
        Whether the table has a law for particles that arrive spinning.
    domain : Domain
        Impact angles, speeds and variables that a table covers.
    model : ModelSettings
        Numerical parameters of the direct model.
    table : TableSettings
        How the table is made, where the generator shall not choose.
    accuracy : AccuracyTargets
        Largest distances from direct simulation that the table declares.
    spin_accuracy : SpinTargets or None
        The same for the spin law. `spin_targets` fills in what is not given.

    Examples
    --------
    >>> from tablegen import load_config
    >>> config = load_config("corundum-steel")
    >>> config.pair.wall, config.domain.speed
    ('steel St3', (5.0, 300.0))
    """

    name: Name
    pair: MaterialPair
    population: Population
    spin: bool = False
    domain: Domain
    model: ModelSettings = ModelSettings()
    table: TableSettings = TableSettings()
    accuracy: AccuracyTargets = AccuracyTargets.model_validate({})
    spin_accuracy: SpinTargets | None = None
    _text: str = PrivateAttr()

    def model_post_init(self, _: object) -> None:
        """Write out all fields, defaults included; `_checked` may set a given text instead."""
        tree = self.model_dump(mode="json", by_alias=True, exclude_none=True)
        self._text = tomli_w.dumps(tree)

    @model_validator(mode="after")
    def _aspect_where_needed(self) -> Self:
        if self.population.lacks_aspect:
            allowed = "a law of the aspect ratios, which all shapes but spheres and meshes need"
            raise refusal("population.aspect", MISSING, allowed)
        return self

    @model_validator(mode="after")
    def _within_validity(self) -> Self:
        valid, (first, last) = self.pair.restitution.valid_speed, self.domain.speed
        if self.domain.extrapolate:
            return self
        if valid is None:
            allowed = "true, because the restitution law states no validity range (valid_speed)"
            raise refusal("domain.extrapolate", False, allowed)
        if first < valid[0] or last > valid[1]:
            allowed = (
                f"inside the restitution law's validity range [{valid[0]:g}, {valid[1]:g}] m/s, "
                "or set domain.extrapolate = true"
            )
            raise refusal("domain.speed", self.domain.speed, allowed)
        return self

    @model_validator(mode="after")
    def _spin_gives_states(self) -> Self:
        others = [name for name in self.domain.columns if name not in (*STATE, *WORKS)]
        if self.spin and others:
            allowed = f"false with {', '.join(others)} among the variables, which it does not give"
            raise refusal("spin", self.spin, allowed)
        return self

    @model_validator(mode="after")
    def _nodes_span_domain(self) -> Self:
        for field, nodes, source, ends in (
            ("alpha_nodes_deg", self.table.alpha_nodes_deg, "alpha_deg", self.domain.alpha_deg),
            ("speed_nodes", self.table.speed_nodes, "speed", self.domain.speed),
        ):
            if nodes is not None and (nodes[0], nodes[-1]) != ends:
                allowed = f"first and last node at the ends of domain.{source}, {shown(ends)}; "
                allowed += "without this list, generate places the nodes"
                raise refusal(f"table.{field}", nodes, allowed)
        return self

    @property
    def text(self) -> str:
        """TOML text that needs no other file and parses to this same configuration."""
        return self._text

    @property
    def pair_name(self) -> str:
        """Name of the material pair, which is that of the pair file if this is a scene."""
        return self.pair.name or self.name

    @property
    def spin_targets(self) -> SpinTargets:
        """Largest distances that the spin law declares."""
        given = self.spin_accuracy.model_dump(exclude_none=True) if self.spin_accuracy else {}
        preset = {"preset": self.accuracy.preset}
        return SpinTargets.model_validate({**preset, **CHAIN_LIMITS, **given})

    def doubts(self) -> list[str]:
        """Say which values are allowed but look like mistakes, one on each line."""
        lines, domain = [], self.domain
        if domain.alpha_deg[1] < _LIKE_RADIANS:
            lines.append(f"domain.alpha_deg: {shown(domain.alpha_deg)} degrees look like radians")
        deviation = getattr(self.population.aspect, "standard_deviation", 0.0)
        if deviation > 1.0:
            lines.append(
                f"population.aspect.standard_deviation: {deviation:g} is more than any ratio"
            )
        for name, limit in self.accuracy.model_dump(exclude={"preset"}).items():
            if limit > 1.0:
                lines.append(f"accuracy.{name}: any table is within {limit:g}")
        return lines

    def with_changes(self, changes: Tree) -> "Config":
        """Return a configuration with some fields changed, by the rules of a scene.

        Parameters
        ----------
        changes : dict
            New values, nested as in a file, for example ``{"table": {"seed": 2}}``. Paths of mesh
            files are relative to the working folder.

        Returns
        -------
        Config
            The changed configuration. This one stays as it is.

        Raises
        ------
        InputError
            If a field does not exist or the result is not allowed.

        Notes
        -----
        Tables are merged field by field, with the exceptions that a scene has: a table of another
        ``law``, ``distribution`` or ``preset`` replaces the old one, a changed range of the domain
        drops the nodes of the old range, and a population with new shapes or meshes has no others.

        Examples
        --------
        >>> from tablegen import load_config
        >>> config = load_config("corundum-steel")
        >>> slow = config.with_changes({"domain": {"speed": [5.0, 50.0]}})
        >>> slow.domain.speed
        (5.0, 50.0)
        """
        origin = f"{self.name}, changed"
        changes = _written_out(changes, origin, Path())
        return _checked(merged(tomllib.loads(self.text), changes), origin)


def load_config(name_or_path: str | Path) -> Config:
    """Read a material pair or a scene.

    Parameters
    ----------
    name_or_path : str or Path
        A name that comes with the package, such as "corundum-steel", or the path of a file.

    Returns
    -------
    Config
        The checked configuration. A scene is complete: it has the fields of its pair file.

    Raises
    ------
    InputError
        If there is no such file or name, or if the file cannot be used. The message names the file,
        the field, what was given and what is allowed.

    Examples
    --------
    >>> from tablegen import load_config
    >>> load_config("corundum-steel").pair_name
    'corundum-steel'
    """
    path = find_config(name_or_path)
    return parse_config(read_text(path), path.name, path.parent)


def load_population(name_or_path: str | Path) -> Tree:
    """Read ``[population]`` of a file or a shipped pair, or write out one of `GRAINS`.

    A file needs no other section. Errors are those of `load_config`.
    """
    if str(name_or_path) in GRAINS:
        return named_population(str(name_or_path))
    try:
        path = find_config(name_or_path)
    except InputError as error:
        names = f"{', '.join(GRAINS)}, a shipped pair, or the path of a .toml file"
        raise InputError("grains", shown(str(name_or_path)), names) from error
    tree = _written_out(parse_toml(read_text(path), path.name), path.name, path.parent)
    if isinstance(tree.get("pair"), str):
        return load_config(path).population.model_dump(
            mode="json", by_alias=True, exclude_none=True
        )
    try:
        population = Population.from_tree(tree.get("population", {}))
    except ValidationError as error:
        raise complaint(error, Population, "population.").within(path.name) from error
    return population.model_dump(mode="json", by_alias=True, exclude_none=True)


def parse_config(text: str, origin: str, directory: Path | None = None) -> Config:
    r"""Read a configuration from the TOML text of a pair file or a scene.

    Parameters
    ----------
    text : str
        Content of the file.
    origin : str
        Name for the text, with which each error message begins.
    directory : Path, optional
        Folder to which paths of pair files and mesh files in the text are relative. By default the
        working folder.

    Returns
    -------
    Config
        The checked configuration.

    Raises
    ------
    InputError
        If the text cannot be used, as for `load_config`.

    Examples
    --------
    >>> from tablegen import parse_config
    >>> text = 'pair = "corundum-steel"\nname = "slow"\ndomain.speed = [5.0, 50.0]'
    >>> parse_config(text, "slow.toml").domain.speed
    (5.0, 50.0)
    """
    directory = directory or Path()
    tree = parse_toml(text, origin)
    data = _written_out(tree, origin, directory)
    if not isinstance(data.get("pair"), str):
        return _checked(data, origin, text if data == tree else None)
    reference = data.pop("pair")
    base = _pair_of_scene(reference, origin, directory)
    base_tree = tomllib.loads(base.text)
    # a scene without a name must not take that of the pair, or it would pass for the pair
    del base_tree["name"]
    whole = merged(base_tree, data)
    whole["pair"].setdefault("name", base.name)
    return _checked(whole, origin)


def stored_config(text: str, origin: str) -> Config:
    """Read the ``config`` of a table as `parse_config` does, without opening another file.

    A text that names a file, for the pair or for a mesh, is refused.
    """
    tree = parse_toml(text, origin)
    if isinstance(tree.get("pair"), str):
        allowed = "the laws of the pair themselves, in the configuration of a table"
        raise InputError("pair", shown(tree["pair"]), allowed, source=origin)
    return _checked(tree, origin, text)


def scene_over(config: Config, name_or_path: str | Path) -> tuple[Config, str | None]:
    """Lay a scene over the configuration of a table.

    Returns the configuration, and the name of the pair file that the scene refers to, or None. If
    the scene is a pair file, its laws count as changes. Errors are those of `load_config`.
    """
    path = find_config(name_or_path)
    tree = _written_out(parse_toml(read_text(path), path.name), path.name, path.parent)
    named = tree.pop("pair") if isinstance(tree.get("pair"), str) else None
    tree.pop("name", None)
    return _checked(merged(tomllib.loads(config.text), tree), path.name), named


def read_text(path: Path) -> str:
    """Read a text file, and drop the byte-order mark that some editors write."""
    try:
        text = read_file("file", path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        position = f"byte {error.object[error.start]:#04x} at position {error.start}"
        raise InputError("", position, "UTF-8 text", source=path.name) from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _pair_of_scene(reference: str, origin: str, directory: Path) -> Config:
    """Read the pair file that a scene refers to, by name or by a path relative to its folder."""
    is_path = reference.endswith(".toml") or len(Path(reference).parts) > 1
    try:
        path = find_file("pair", directory / reference if is_path else reference, ".toml")
    except InputError as error:
        raise error.within(origin) from None
    text = read_text(path)
    if isinstance(parse_toml(text, path.name).get("pair"), str):
        allowed = "a pair file"
        raise InputError("pair", f"'{reference}', a scene itself", allowed, source=origin)
    return parse_config(text, path.name, path.parent)


def _written_out(tree: Tree, origin: str, directory: Path) -> Tree:
    """Write out a named population, and the vertices of every mesh file that a tree names."""
    population = tree.get("population")
    if isinstance(population, str):
        return {**tree, "population": named_population(population, origin)}
    meshes = population.get("meshes") if isinstance(population, dict) else None
    if not isinstance(population, dict) or not isinstance(meshes, list | tuple):
        return dict(tree)
    whole = []
    for i, mesh in enumerate(meshes):
        if isinstance(mesh, dict) and "vertices" not in mesh and isinstance(mesh.get("file"), str):
            try:
                read = read_mesh(directory / mesh["file"])
            except InputError as error:
                field = f"population.meshes[{i}].file"
                raise error.replaced(argument=field, source=origin) from None
            for line in read.doubts():
                _LOG.warning("%s", line)
            vertices = [list(row) for row in read.vertices]
            whole.append({**mesh, "file": read.name, "vertices": vertices})
        else:
            whole.append(mesh)
    return {**tree, "population": {**population, "meshes": whole}}


def _with_preset(tree: Tree) -> Tree:
    """Give the limits of the spin law the preset of ``accuracy``, unless they have their own."""
    accuracy, spin = tree.get("accuracy"), tree.get("spin_accuracy")
    if isinstance(accuracy, dict) and isinstance(spin, dict) and "preset" in accuracy:
        return {**tree, "spin_accuracy": {"preset": accuracy["preset"], **spin}}
    return tree


def _checked(tree: Tree, origin: str, text: str | None = None) -> Config:
    """Validate a tree. ``text``, if given, is complete and becomes the configuration's text."""
    try:
        config = Config.from_tree(_with_preset(tree))
    except ValidationError as error:
        raise complaint(error, Config).within(origin) from error
    if text is not None:
        config._text = text
    return config
