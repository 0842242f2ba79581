"""Run the command line as ``python -m tt_precise``, where ``tt-precise`` is not on the path."""

from tt_precise.cli import entry

if __name__ == "__main__":
    entry()
