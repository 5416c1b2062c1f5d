"""Simulated statistics in the form of measured ones, and contact laws fitted to them."""
