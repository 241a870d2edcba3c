"""Turns a model (equations and a table) into an FMU file."""
