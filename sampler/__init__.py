"""Draw the rebounds of non-spherical particles from a table.

`load` reads a table. Its method `Table.rebound` takes velocities before a wall, and gives
velocities and spins after it, in the lab frame. `Table.sample` draws states in the frame of the
wall. Both take keys for the random numbers: the seed of a run, the index of each particle, and the
number of walls that it has met. Equal keys give equal rebounds.

>>> import numpy as np
>>> import sampler
>>> table = sampler.load("corundum-steel")
>>> velocity, omega, inertia = table.rebound(
...     velocity=np.tile([120.0, -90.0, 0.0], (1000, 1)),  # m/s
...     normal=[0.0, 1.0, 0.0],  # from the wall into the gas
...     half_size=20e-6,  # m
...     seed=7,
...     index=np.arange(1000),
...     hit=0,
... )
>>> bool((velocity[:, 1] > 0.0).all())  # every particle leaves the wall
True

Pass ``omega`` and ``inertia`` to the next rebound of each particle. `sampler.numba` has draws for
code that numba compiles, and `sampler.errors` lists the codes of rows. The functions of this module
compute what a particle tracker needs beside a rebound, such as `spin_after` and `deposits`.
"""

import lazy_loader

# each name of __init__.pyi is imported when it is first used
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
