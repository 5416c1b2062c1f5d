"""The command line of the generator: a file a command, which imports its work when it runs."""
