"""The precision report: one HTML file, its Markdown twin, results as JSON, figures as SVG."""
