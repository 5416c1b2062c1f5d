"""How kernels are compiled, what is imported late, and on how many processors they run."""
