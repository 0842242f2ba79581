"""The code that the numbers of a trajectory rest on, for what keeps results beside its hash."""

# files and folders of the package; tests/test_structure.py compares them with the imports
SOURCES = (
    "runtime/arithmetic.py", "runtime/mpfr.py", "runtime/toml.py",
    "scene", "mechanics", "taylor", "integration",
)  # fmt: skip
