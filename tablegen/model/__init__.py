"""The direct model of a rebound: numba kernels on floats and arrays, nothing else.

contact_laws      restitution and resistance at the contact point
coulomb           one collision under Coulomb friction; coulomb_rates, sliding_series: its parts
collision         one collision, equations (1)-(7) of the paper
shapes            vertices, moments of inertia, support function
support_map       the few vertices of a mesh that may lie farthest along a direction
rotation          free rotation of an asymmetric body as a Taylor series
contact           when and where a free particle next touches the wall
conditions        impact conditions, of one particle or of many
rebound           a whole rebound: collisions and flights until the particle has left
lockstep          many particles of one shape, eight at a time
audit             every law checked on every collision and flight; coulomb_audit: friction
random_particles  random shape, aspect ratios and orientation
particle_run      many particles, at one condition or at one each
impacts           conditions from angles and speeds, or from velocities in the lab frame
one_rebound       one rebound for the user's own compiled code
simd              vector values of eight floats, and what they share with floats
"""
