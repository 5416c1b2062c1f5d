"""Simulated rebounds beside measured ones."""
