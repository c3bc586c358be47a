"""What must be asked: neither the files nor the options say it."""

from __future__ import annotations

from stickslip.errors import InputError


class LackingError(InputError):
    """Something is not known.

    Parameters
    ----------
    question
        What it is.
    option
        The option that says it.
    begins
        What the option's value begins with; the answer follows.
    """

    def __init__(self, question: str, *, option: str, begins: str = "") -> None:
        super().__init__(f"not known from the files: {question}; give {option} '{begins}...'")
        self.question, self.option, self.begins = question, option, begins
