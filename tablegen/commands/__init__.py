"""Options and help of each command of ``tablegen``; nothing here imports what does the work."""
