"""Stability study: extreme particles, impacts and spins, each checked against the model's laws."""
