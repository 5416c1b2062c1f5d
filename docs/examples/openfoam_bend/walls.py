"""Impacts that OpenFOAM wrote down, sorted by wall and by place."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from foam_files import CLOUD
from numpy.typing import NDArray
from wall_impacts import Impacts

FloatArray = NDArray[np.float64]

#: Walls of the case, patches of its mesh.
WALLS = ("outer", "inner", "sides")

#: The bend turns about (0, CENTRE) [m], from x to y; radii of its walls and of its middle line [m].
CENTRE, INNER, OUTER = 0.2, 0.1, 0.2
TURN = 0.5 * math.pi * 0.5 * (INNER + OUTER)

#: Faces of the mesh along the bend; a wall is flat within each.
_FACES = 20

#: Groups of parcels, and the parcels that each injects a second.
GROUPS, RATE = 20, 3e6 / 20

#: Speed [m/s] at the inlet, and the times [s] in which impacts are counted: the duct is full.
SPEED, START, END = 150.0, 0.008, 0.014


class Records(NamedTuple):
    """Impacts on all walls, n of them, in the order of time.

    ``time``, ``place``, ``depth`` (n,): s, m along the middle line from the start of the bend, m
    from one side wall. ``speed``, ``angle`` (n,): m/s and degrees. ``parcel``, ``hit``, ``wall``
    (n,): its origId, how many walls it has met before, index into `WALLS`.
    """

    time: FloatArray
    place: FloatArray
    depth: FloatArray
    speed: FloatArray
    angle: FloatArray
    parcel: NDArray[np.int64]
    hit: NDArray[np.int64]
    wall: NDArray[np.int64]


def places(x: FloatArray, y: FloatArray) -> FloatArray:
    """Places along the middle line, from the start of the bend, m."""
    turned = np.arctan2(np.maximum(x, 0.0), np.maximum(CENTRE - y, 0.0))
    return np.minimum(x, 0.0) + TURN * turned / (0.5 * math.pi) + np.maximum(y - CENTRE, 0.0)


def outward(wall: str, place: FloatArray, depth: FloatArray) -> FloatArray:
    """Normals of the mesh from the gas into a wall, shape (n, 3)."""
    normal = np.zeros((len(place), 3))
    if wall == "sides":
        normal[:, 2] = np.where(depth > 0.5 * (OUTER - INNER), 1.0, -1.0)
        return normal
    face = np.floor(np.clip(place / TURN, 0.0, 1.0 - 1e-12) * _FACES) + 0.5
    turned = np.where(place > TURN, 1.0, np.where(place < 0.0, 0.0, face / _FACES)) * 0.5 * math.pi
    sign = 1.0 if wall == "outer" else -1.0
    normal[:, 0], normal[:, 1] = sign * np.sin(turned), -sign * np.cos(turned)
    return normal


def _rows(case: Path, wall: str) -> FloatArray:
    """Rows of a wall's files: time, processor, position, origId, velocity."""
    folder = case / "postProcessing" / "lagrangian" / CLOUD / "impacts"
    rows = [np.empty((0, 9))]
    for path in sorted(folder.glob(f"*/{wall}.post"), key=lambda path: float(path.parent.name)):
        lines = path.read_text(encoding="ascii").splitlines()[1:]
        text = " ".join(lines).replace("(", " ").replace(")", " ")
        rows.append(np.array(text.split(), dtype=float).reshape(-1, 9))
    return np.vstack(rows)


def _hits(parcel: NDArray[np.int64]) -> NDArray[np.int64]:
    """How many rows before it each row's parcel has."""
    order = np.argsort(parcel, kind="stable")
    firsts = np.searchsorted(parcel[order], parcel[order])
    hit = np.empty(len(parcel), dtype=np.int64)
    hit[order] = np.arange(len(parcel)) - firsts
    return hit


def read_records(case: Path) -> Records:
    """Impacts of a run; a contact of a parcel that already leaves the wall is none."""
    parts = []
    for number, wall in enumerate(WALLS):
        time, _, x, y, z, parcel, *velocity = _rows(case, wall).T
        place, v = places(x, y), np.array(velocity).T
        speed = np.linalg.norm(v, axis=1)
        into = (v * outward(wall, place, z)).sum(axis=1)
        angle = np.degrees(np.arcsin(np.minimum(into / speed, 1.0)))
        table = np.column_stack([time, place, z, speed, angle, parcel, np.full(len(time), number)])
        parts.append(table[into > 0.0])
    table = np.vstack(parts)
    *floats, parcel, wall = table[np.argsort(table[:, 0], kind="stable")].T
    parcel, wall = parcel.astype(np.int64), wall.astype(np.int64)
    return Records(*floats, parcel, _hits(parcel), wall)


def counted(records: Records, wall: str) -> tuple[Impacts, FloatArray]:
    """Impacts on one wall while the duct is full, and their distances from a side wall, m."""
    here = (records.wall == WALLS.index(wall)) & (records.time > START) & (records.time <= END)
    chosen = Records(*(column[here] for column in records))
    impacts = Impacts(chosen.parcel % GROUPS, chosen.hit, chosen.place, chosen.speed, chosen.angle)
    return impacts, chosen.depth


def injected() -> NDArray[np.int64]:
    """Parcels of each group that are injected while impacts are counted."""
    return np.full(GROUPS, round(RATE * (END - START)))
