"""A guard against guessing: after some wrong logins in a row, over all connections, the answers come late."""

from hmac import compare_digest
from typing import Final

from fieldrig.clock import S

ALARM_AFTER: Final = 3
"""Wrong logins in a row from which on every answer is delayed."""
DELAY_NS: Final = 10 * S


Credentials = tuple[bytes, bytes]
"""A user name and a password."""


class LoginGuard:
    def __init__(self) -> None:
        self.failures = 0
        """The number of wrong logins since the last right one."""

    @property
    def is_alarmed(self) -> bool:
        return self.failures >= ALARM_AFTER

    @property
    def delay_ns(self) -> int:
        """The time in nanoseconds by which the answer to a login is delayed."""
        return DELAY_NS if self.is_alarmed else 0

    def is_right(self, given: Credentials, wanted: Credentials) -> bool:
        """Check a login, and count it if it is wrong.

        Both parts are compared, and in a time that says nothing about where they differ.
        """
        is_right = compare_digest(given[0], wanted[0]) & compare_digest(given[1], wanted[1])
        self.failures = 0 if is_right else self.failures + 1
        return is_right
