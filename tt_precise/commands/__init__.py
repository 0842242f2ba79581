"""The commands of ``tt-precise``, one file each: parse options, call the API, print."""
