"""How kernels are compiled, on how many processors they run, and public names imported late."""
