"""Long work in pieces: run on any executor, kept on disk, shown by progress bars."""
