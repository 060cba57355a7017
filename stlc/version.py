"""The version, for whoever needs no more of the package."""

__version__ = "0.2.0"
