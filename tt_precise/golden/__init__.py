"""Golden reference trajectories: build, load, verify."""
