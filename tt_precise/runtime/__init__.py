"""What knows no physics: files, cache, processes, progress, the terminal, records."""
