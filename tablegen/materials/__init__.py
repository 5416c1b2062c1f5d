"""Material pairs: the contact laws of a particle material on a wall material, as records."""
