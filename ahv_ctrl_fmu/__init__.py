"""The control laws of the vehicle."""
