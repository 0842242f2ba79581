"""Speed against accuracy: problems, methods, measurement, and findings."""
