"""Draws on a GPU, through CuPy: nothing here is imported before `Table.to_device` is called."""
