"""Errors in a user's input: one line that says what was got, what is expected, what to do."""


class InputError(ValueError):
    """Input that cannot be used; its message is one complete line, shown to the user as it is."""
