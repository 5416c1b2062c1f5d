"""The direct model of a rebound: numba kernels on floats and arrays, and nothing above them.

The files, in the order of a rebound:

1. Which particle, and how does it arrive?
   random_particles  shape, aspect ratios and orientation, from random_numbers (Philox)
   tumbling          orientation of a grain that turns with a given spin and inertia
   impacts           angle, speed and spin of an impact, from the frame of the wall or of the lab
   frames            vectors, and the frame of the wall in the lab; roughness: facets of a wall
   shapes            vertices, moments of inertia and lowest point of the body
2. rebound           collisions and flights, one after another, until the particle has left:
   reach             how far the tumbling body can reach: where it starts, and when it has left
   contact           when and where the body next touches the wall
   rotation          how it turns meanwhile: free rotation of an asymmetric body, a Taylor series
   contact_laws      what a contact gives back: a_nc (6) and C_f (7)
   collision         the impulse of a contact, equations (1)-(5): the root of a cubic
   coulomb           the same under Coulomb friction; sliding: its pieces
rebound follows one particle, lockstep eight of a shape at a time, in the lanes of vector registers
(simd), by the same functions; particle_run calls them for many. audit checks every collision and
flight of a run against the laws in their defining form. elementary has functions with the same bits
everywhere, model_bounds the allowed arguments, float_array a name for type hints. jit compiles, and
parts makes that faster.

Numbers are those of the paper (Panfilov & Tsirkunov 2022): lengths over a, the largest half-size,
velocities over the impact speed V, angular velocities times a / V, mass one. A kernel takes those
of one particle or of several in lanes, unless its docstring says otherwise: a shape such as (13,)
stands for (13, WIDTH) too.
"""
