"""The text that is said of a process that has ended."""

import pytest

from fieldrig.real.child import why_it_ended
from fieldrig.system.exits import Exit

TRACEBACK = "Traceback (most recent call last):\n  ...\nImportError: cannot import name 'x'"


@pytest.mark.parametrize(
    ("code", "said", "why"),
    [
        (1, TRACEBACK, "exit code 1 (ImportError: cannot import name 'x')"),
        (1, "", "exit code 1"),
        (-9, TRACEBACK, "killed by SIGKILL"),
        (Exit.CRASHED, TRACEBACK, "exit code 70: a device's code failed (ImportError: cannot import name 'x')"),
    ],
)
def test_the_reason_has_the_last_line_of_a_traceback(code: int, said: str, why: str) -> None:
    """The death of the page was reported by its exit code alone, and the reason was in a log that nothing named."""
    assert why_it_ended(code, said) == why
