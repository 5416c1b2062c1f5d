"""Version of both packages: the one place that states it, read by the build too."""

__version__ = "1.0.0"
