"""Configurations: material pairs, scenes, populations and laws as checked records."""
