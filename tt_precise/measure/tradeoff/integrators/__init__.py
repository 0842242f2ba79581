"""The integrators that are compared, a package a file; each method is one registered function."""
