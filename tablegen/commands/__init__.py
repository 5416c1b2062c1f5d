"""Commands of ``tablegen``: one file for each, with its options, its help and its work."""
