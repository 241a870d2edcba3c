"""Flies FMU files together; knows nothing of what is inside them."""
