"""Rebound states of non-spherical particles, drawn from a table.

>>> import numpy as np
>>> import sampler
>>> table = sampler.load("corundum-steel")
>>> state = table.sample(0.5, 150.0, size=1000, rng=np.random.default_rng(1))  # 0.5 rad, 150 m/s
>>> state.shape, table.columns
((1000, 6), ('u', 'v', 'w', 'omega_x', 'omega_y', 'omega_z'))
>>> bool((state[:, 1] > 0.0).all())  # every particle leaves the wall
True

The columns are u, v, w over V and omega_x, omega_y, omega_z times a/V. ``table.rebound`` does the
same for velocities in the lab frame. Both take keys in place of a generator: the seed of a run, the
index of each particle and how many walls it has hit. Of particles that arrive
spinning, give the spin (``spin=``, ``omega=``); each has one grain, from wall to wall.
`sampler.numba` has both calls for code compiled by numba, and `sampler.errors` the codes of rows.
"""

import lazy_loader

# each name of __init__.pyi is imported when it is first used
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
