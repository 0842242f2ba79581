"""The code that the numbers of a trajectory rest on, for what keeps results beside its hash."""

# files and folders of the package; tests/test_structure.py compares them with the imports
SOURCES = (
    "arithmetic.py", "body.py", "compliance.py", "dry_friction.py", "initial_state.py", "mpfr.py",
    "numerals.py", "scene.py", "start.py", "toml.py", "integrate", "mechanics", "taylor",
)  # fmt: skip
