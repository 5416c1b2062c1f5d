"""The command line of the runtime, and what that of the generator shares with it."""
