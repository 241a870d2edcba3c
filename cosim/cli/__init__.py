"""The command line `ahv`."""
from .app import main

__all__ = ["main"]
