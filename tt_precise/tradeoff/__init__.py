"""Speed against accuracy: what is integrated, by what, measured how, and what follows."""
