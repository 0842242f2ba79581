"""``python -m tt_precise`` is ``tt-precise``, where the latter is not on the path."""

from tt_precise.cli import entry

if __name__ == "__main__":
    entry()
