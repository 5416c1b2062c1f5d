"""Draws on a GPU, through CuPy. `Table.to_device` imports this package when it is called."""
