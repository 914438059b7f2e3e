"""Why a serial port cannot be opened, in words for a person; pyserial has the number of the error twice in its text."""

import os
import re

CONFIGURING = re.compile(r"\((\d+), '")
"""The number, in pyserial's text, of an error that it met when it set the rate of the port."""


def reason(cause: Exception) -> str:
    """Return such as `No such file or directory`; the text of the exception if it has no number of an error."""
    number = getattr(cause, "errno", None)
    if isinstance(number, int):
        return os.strerror(number)
    match = CONFIGURING.search(str(cause))
    return f"it is no serial port ({os.strerror(int(match[1]))})" if match else str(cause)
