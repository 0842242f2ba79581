"""What is raised when a hypothesis of the theorem fails to verify."""

from __future__ import annotations


class NotProved(ArithmeticError):  # noqa: N818 - a verdict, not a mistake
    """A hypothesis did not verify, so nothing is claimed; never a statement that it is false.

    ``hypothesis`` names it as in the docstring of ``tt_precise.certify``.
    """

    def __init__(self, hypothesis: str, reason: str):
        super().__init__(f"not proved ({hypothesis}): {reason}")
        self.hypothesis, self.reason = hypothesis, reason

    def __reduce__(self) -> tuple[type[NotProved], tuple[str, str]]:
        return NotProved, (self.hypothesis, self.reason)
