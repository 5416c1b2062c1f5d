"""The direct model of a rebound: numba kernels on floats and arrays, nothing else.

A kernel takes the numbers and arrays of one particle or of several in lanes (`simd`), unless its
docstring says otherwise: a shape such as (13,) stands for (13, WIDTH) too.

jit               options of the compiler, cache of machine code
simd              vector values of eight floats, and the operations they share with floats
elementary        exponential, logarithm, sine and cosine with the same bits everywhere
random_numbers    Philox and the normal quantile
frames            vectors, and the frame of the wall in the lab frame
roughness         facets of rough walls
contact_laws      restitution and resistance at the contact point
collision         one collision, equations (1)-(7) of the paper
coulomb           one collision under Coulomb friction; sliding: its pieces
shapes            vertices, moments of inertia, support function and map
rotation          free rotation of an asymmetric body as a Taylor series
contact           when and where a free particle next touches the wall
impacts           impact conditions, in the frame of the wall or in the lab frame
rebound           a whole rebound: collisions and flights until the particle has left
lockstep          many particles of one shape, eight at a time
audit             every law checked on every collision and flight
random_particles  random shape, aspect ratios and orientation
particle_run      many particles, at one condition or at one each
model_bounds      bounds of the arguments
"""
