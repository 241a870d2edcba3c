"""SSP 1.0 (System Structure and Parameterization): the closed loop written, anybody's system read."""
