"""The direct model of a rebound: kernels compiled by numba, and nothing above them.

Where the physics is
--------------------
To change the physics, open the file of the right line; equation numbers are those of Panfilov &
Tsirkunov 2022.

====================  ==============================================================================
file                  what it computes
====================  ==============================================================================
contact_laws          restitution a_nc, equation (6), and sliding resistance C_f, equation (7), and
                      the other laws that a material pair may name
collision             the impulse of one collision, equations (1) to (5): the root of a cubic
coulomb, sliding      the same under Coulomb friction with stick and slip (Routh, Stronge)
rotation              free rotation between collisions: Euler's equations as a Taylor series
contact               when and where the turning body next touches the wall
shapes                vertices and moments of inertia of the shapes; the lowest point of a body
rebound               the sequence: collision, flight, collision, ... until the particle has left
reach                 how far a tumbling body reaches: where its fall begins, when it has left
tumbling              orientations of a grain that arrives with a given spin and inertia
random_particles      the orientation in which a particle meets the wall
impacts, vectors      the condition of an impact, and vectors of three numbers
model_bounds          the arguments that the model accepts
====================  ==============================================================================

Grains, facets of rough walls and the lab frame are not here: the C engine of `sampler` has them for
every law of a wall, and calls `particle_run` for the states in wall axes.

`tests/reference/reference_model.py` has the same model once more, written to be read and not to be
fast. `tests/reference/audit.py` checks every collision and flight against the laws in their
defining form.

The other files make the kernels fast and repeatable, and know nothing of the physics: jit compiles
them, simd gives them vector registers, memory gives them arrays, lockstep and particle_run call
them for many particles, elementary and random_numbers give functions and random numbers with the
same bits everywhere, float_array names a type.

How a kernel is written
-----------------------
A function of the physics serves one particle and eight at once, in the lanes of vector registers.
Its numbers are then floats or lanes, and its conditions are truth values or one for each lane. So

- take ``select(condition, a, b)`` in place of ``a if condition else b``, and ``minimum``,
  ``maximum`` and ``sqrt`` of `tablegen.model.simd`, which accept both;
- repeat a loop while ``any_lane(searching)`` holds, and change only the lanes that still search;
- read and write arrays by ``load`` and ``store``: the lanes are the last dimension, so an array
  with the shape (13,) for one particle has the shape (13, WIDTH) for eight.

Docstrings give the shapes for one particle. A law that cannot be written so, because it needs the
C library or a search in a table, is computed lane by lane; see ``other_restitution`` in
contact_laws for an example.

Units
-----
Those of the paper: lengths over the largest half-size a, velocities over the impact speed V,
angular velocities times a / V, mass one. Only laws of contact need m/s. Wall axes are x along the
wall in the plane of the impact, y along the wall normal into the gas, z across both. Body axes are
the principal axes.
"""
