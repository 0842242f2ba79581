"""Conservation checks on a trajectory from anywhere."""
