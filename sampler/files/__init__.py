"""Files found by name, and files written whole or not at all."""
