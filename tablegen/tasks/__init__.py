"""Long work in tasks: run on any executor, checkpoints on disk, progress bars."""
