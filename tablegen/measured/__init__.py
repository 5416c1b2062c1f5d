"""Measured rebounds: reading, comparing, calibrating."""
