"""Tables: grid, refinement, generation, pruning."""
