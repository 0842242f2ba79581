"""The sections of the report, one file each: ``section()`` computes and returns it."""
