"""Particles of all shapes, and of two meshes with very different numbers of vertices."""

from mesh_fixtures import POPULATION, box, grain

from tablegen.config.population import MeshShape, Population

CROWD = Population.model_validate(
    POPULATION.model_dump(by_alias=True)
    | {
        "shapes": dict.fromkeys(POPULATION.shapes.model_dump(by_alias=True), 1.0),
        "meshes": tuple(
            MeshShape(vertices=tuple(map(tuple, points.tolist())), weight=2.0)
            for points in (grain(200), box(0.5, 0.3))
        ),
    }
)
