"""Scenes: body, start and run as exact numbers, and the shipped scenes."""
