"""What can go wrong with what a user hands in: one line that says got, expected, what to do."""


class InputError(ValueError):
    """Input that cannot be used; its message is one complete line, shown to the user as it is."""
