"""Hostile input, full disks, interruptions: old or new, one line, and nothing left behind."""
