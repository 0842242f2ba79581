"""The precision report: HTML, Markdown, results as JSON, figures as SVG."""
