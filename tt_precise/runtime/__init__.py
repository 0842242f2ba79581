"""Tools without physics: files, cache, processes, progress, the terminal, records."""
