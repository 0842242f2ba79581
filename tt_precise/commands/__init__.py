"""The commands of ``tt-precise``, one file each: parse, call the API, print."""
