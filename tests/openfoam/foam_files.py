"""Write parcels to OpenFOAM's ASCII files before a run, and read them after it."""

import re
from pathlib import Path

import numpy as np

CLOUD = "kinematicCloud"
#: Says whether a cloud lies in the file `positions` or in the file `coordinates`.
GEOMETRY = f"0/uniform/lagrangian/{CLOUD}/cloudProperties"
_HEADER = """FoamFile
{{
    version     2.0;
    format      ascii;
    class       {kind};
    object      {name};
}}

"""
_SCALARS = ("tTurb", "age", "dTarget")
_VECTORS = ("UTurb", "f", "angularMomentum", "torque")
#: Contacts of a colliding parcel: empty lists here.
_RECORDS = {
    "collisionRecordsPairAccessed": "labelFieldField",
    "collisionRecordsPairOrigProcOfOther": "labelFieldField",
    "collisionRecordsPairOrigIdOfOther": "labelFieldField",
    "collisionRecordsPairData": "vectorFieldField",
    "collisionRecordsWallAccessed": "labelFieldField",
    "collisionRecordsWallPRel": "vectorFieldField",
    "collisionRecordsWallData": "vectorFieldField",
}


def _rows(values):
    """Write rows of a list: numbers, or vectors in parentheses, with all their digits."""
    values = np.asarray(values)
    if values.ndim == 1:
        return "\n".join(map(repr, values.tolist()))
    return "\n".join(f"({' '.join(map(repr, row))})" for row in values.tolist())


def _write(path, kind, text):
    path.write_text(_HEADER.format(kind=kind, name=path.name) + text + "\n", encoding="ascii")


def _write_field(path, values):
    values = np.asarray(values)
    if values.ndim == 2:
        kind = "vectorField"
    else:
        kind = "labelField" if values.dtype.kind == "i" else "scalarField"
    _write(path, kind, f"{len(values)}\n(\n{_rows(values)}\n)")


def write_cloud(case, position, velocity, diameter, density):
    """Write a cloud at time 0 (SI): parcels that have met no wall, origId 0 to n - 1."""
    cloud = Path(case) / "0" / "lagrangian" / CLOUD
    cloud.mkdir(parents=True, exist_ok=True)
    n = len(position)
    (Path(case) / GEOMETRY).parent.mkdir(parents=True, exist_ok=True)
    _write(Path(case) / GEOMETRY, "dictionary", "geometry positions;")
    # cell -1: OpenFOAM looks for it
    rows = "\n".join(f"({' '.join(map(repr, row))}) -1" for row in position.tolist())
    _write(cloud / "positions", "Cloud<passiveParticle>", f"{n}\n(\n{rows}\n)")
    _write_field(cloud / "U", velocity)
    _write_field(cloud / "d", np.full(n, diameter))
    _write_field(cloud / "rho", np.full(n, density))
    _write_field(cloud / "nParticle", np.ones(n))
    _write_field(cloud / "active", np.ones(n, dtype=int))
    _write_field(cloud / "typeId", np.full(n, -1))
    _write_field(cloud / "origProcId", np.zeros(n, dtype=int))
    _write_field(cloud / "origId", np.arange(n))
    for name in _SCALARS:
        _write_field(cloud / name, np.zeros(n))
    for name in _VECTORS:
        _write_field(cloud / name, np.zeros((n, 3)))
    for name, kind in _RECORDS.items():
        _write(cloud / name, kind, f"{n}\n(\n" + "0()\n" * n + ")")


def _read_field(path):
    """Read the values of a field: a list, or one value for all."""
    text = path.read_text(encoding="ascii")
    body = text[text.index("}") + 1 :]
    body = "\n".join(line for line in body.splitlines() if not line.startswith("//"))
    uniform = "{" in body
    opening, closing = ("{", "}") if uniform else ("(", ")")
    count, _, rest = body.partition(opening)
    inside = rest[: rest.rindex(closing)]
    columns = 3 if "(" in inside else 1
    values = np.array(inside.replace("(", " ").replace(")", " ").split(), dtype=float)
    values = values.reshape(-1, columns) if columns > 1 else values
    return np.repeat(values[:1], int(count), axis=0) if uniform else values


def read_cloud(case, time, names):
    """Read fields of a cloud of all processors at a time, in the order of origId, by name."""
    parts = sorted(Path(case).glob("processor*")) or [Path(case)]
    clouds = [part / time / "lagrangian" / CLOUD for part in parts]
    clouds = [cloud for cloud in clouds if (cloud / "origId").exists()]
    fields = {
        name: np.concatenate([_read_field(cloud / name) for cloud in clouds])
        for name in ("origId", "origProcId", *names)
    }
    order = np.lexsort((fields["origId"], fields["origProcId"]))
    return {name: values[order] for name, values in fields.items()}


def read_faces(case, time, name, patch=""):
    """Values of a field on the faces of patches where it is not uniform, or of one patch."""
    values = []
    pattern = rf"{patch}\s*{{[^{{}}]*nonuniform List<scalar>\s*\d+\s*\(([^)]*)\)"
    for part in sorted(Path(case).glob("processor*")) or [Path(case)]:
        text = (part / time / name).read_text(encoding="ascii").partition("boundaryField")[2]
        values += [float(value) for row in re.findall(pattern, text) for value in row.split()]
    return np.array(values)
