"""Flights as pages of HTML, one file each with everything in it: curves to zoom, figures, parameters."""
