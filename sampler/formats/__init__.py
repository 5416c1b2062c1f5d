"""The files of a table: HDF5 and the binary table, their layouts, checks, readers and writers."""
