"""The shapes of particles by name, as `sampler.formats.shape_codes` has them.

`tablegen.model.shapes` has their vertices and moments of inertia.
"""

from sampler.formats.shape_codes import FIRST_MESH as FIRST_MESH
from sampler.formats.shape_codes import SHAPE_CODES as SHAPE_CODES
from sampler.formats.shape_codes import SHAPE_NAMES as SHAPE_NAMES
