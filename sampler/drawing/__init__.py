"""The draw of a rebound state: random words, normals, mixture, quantiles, frames, rough walls."""

# every kernel that gets a table lies in this room
import sampler.drawing.table_type  # noqa: F401
