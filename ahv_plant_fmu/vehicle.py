"""The vehicle's data: the curve fit of Parker et al., J. Guidance Control Dynamics 30(3), 2007.

All quantities are per foot of vehicle depth, in ft, slug, s, rad, lbf. Structural numbers are
confirmed by the paper's Table 1, which they reproduce (with g = 32.0 ft/s², and only with it).
"""

# name, unit, value, description
COEFFICIENTS = [
    ("mass", "slug/ft", 300.0, "vehicle mass m"),
    ("pitch_inertia", "slug.ft", 5e5, "moment of inertia Iyy"),
    ("reference_area", "ft", 17.0, "reference area S"),
    ("chord", "ft", 17.0, "aerodynamic chord c"),
    ("thrust_arm", "ft", 8.36, "thrust moment arm zT"),
    ("gravity", "ft/s^2", 32.0, "acceleration of gravity g, the value behind the paper's Table 1"),
    ("air_density_0", "slug/ft^3", 6.7429e-5, "air density rho0 at h0"),
    ("h_0", "ft", 85000.0, "nominal altitude h0 of the air density"),
    ("h_scale", "ft", 21358.0, "air density decay height hs"),
    ("beta_1", "lbf/ft", -3.7693e5, "thrust: Phi alpha^3"),
    ("beta_2", "lbf/ft", -3.7225e4, "thrust: alpha^3"),
    ("beta_3", "lbf/ft", 2.6814e4, "thrust: Phi alpha^2"),
    ("beta_4", "lbf/ft", -1.7277e4, "thrust: alpha^2"),
    ("beta_5", "lbf/ft", 3.5542e4, "thrust: Phi alpha"),
    ("beta_6", "lbf/ft", -2.4216e3, "thrust: alpha"),
    ("beta_7", "lbf/ft", 6378.5, "thrust: Phi"),
    ("beta_8", "lbf/ft", -100.90, "thrust: constant"),
    ("CL_alpha", "1", 4.6773, "lift: alpha"),
    ("CL_elevator", "1", 0.76224, "lift: elevator"),
    ("CL_0", "1", -0.018714, "lift: constant"),
    ("CD_alpha2", "1", 5.8224, "drag: alpha^2"),
    ("CD_alpha", "1", -0.045315, "drag: alpha"),
    ("CD_elevator2", "1", 0.81993, "drag: elevator^2"),
    ("CD_elevator", "1", 2.7699e-4, "drag: elevator"),
    ("CD_0", "1", 0.010131, "drag: constant"),
    ("CM_alpha2", "1", 6.2926, "pitching moment: alpha^2"),
    ("CM_alpha", "1", 2.1335, "pitching moment: alpha"),
    ("CM_0", "1", 0.18979, "pitching moment: constant"),
    ("CM_elevator", "1", -1.2897, "pitching moment: elevator, the paper's ce"),
    ("N1_alpha2", "1/s^2", 1.4013e3, "generalised force 1, in sqrt(slug ft)/s^2: alpha^2"),
    ("N1_alpha", "1/s^2", 4.5737e3, "generalised force 1, in sqrt(slug ft)/s^2: alpha"),
    ("N1_0", "1/s^2", 117.52, "generalised force 1, in sqrt(slug ft)/s^2: constant"),
    ("N2_alpha2", "1/s^2", -5.0227e3, "generalised force 2, in sqrt(slug ft)/s^2: alpha^2"),
    ("N2_alpha", "1/s^2", 2.8633e3, "generalised force 2, in sqrt(slug ft)/s^2: alpha"),
    ("N2_0", "1/s^2", -44.201, "generalised force 2, in sqrt(slug ft)/s^2: constant"),
    ("N2_elevator", "1/s^2", 1.2465e3, "generalised force 2, in sqrt(slug ft)/s^2: elevator"),
    ("omega_1", "rad/s frequency", 16.0212, "natural frequency of mode 1"),
    ("omega_2", "rad/s frequency", 19.5815, "natural frequency of mode 2"),
    ("zeta_1", "1", 0.02, "damping ratio of mode 1"),
    ("zeta_2", "1", 0.02, "damping ratio of mode 2"),
    ("psi_1", "1", 0.0, "constrained beam coupling of mode 1, in sqrt(slug ft) (printed nowhere; 0 decouples)"),
    ("psi_2", "1", 0.0, "constrained beam coupling of mode 2, in sqrt(slug ft) (printed nowhere; 0 decouples)"),
    ("coupling_sign", "1", 1.0, "sign of the coupling in (6), (7): 1 as printed, -1 as the energy demands"),
]

STRUCTURES = {
    "decoupled": {"psi_1": 0.0, "psi_2": 0.0, "coupling_sign": 1.0},
    # Two uniform cantilevers clamped at the centre of gravity (55 and 45 ft, 300 slug/ft): an
    # estimate, not a datum. As printed, (5)-(7) do not keep energy; with the sign turned they do.
    "estimated-coupling": {"psi_1": -363.5, "psi_2": 328.8, "coupling_sign": 1.0},
    "estimated-coupling-energy": {"psi_1": -363.5, "psi_2": 328.8, "coupling_sign": -1.0},
}
