"""The commands and coefficient changes of a run."""
