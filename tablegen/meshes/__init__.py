"""Meshes: files of them, their convex hull as a particle, and what kernels read of it."""
