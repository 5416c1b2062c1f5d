"""Particle populations: shapes, aspect ratios and convex meshes."""
