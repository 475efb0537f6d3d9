"""The part of the sphere that tests search: the half before the robot."""

from pipeline.placement.params import PlacementParams

HALF = PlacementParams(
    candidates=24,
    by="lattice",
    theta_deg=(-90, 90),
    phi_deg=(0, 75),
    distance_m=None,
    fov_deg=None,
    forbidden=(),
)
