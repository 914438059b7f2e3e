"""The login of FTP: one user, and a delay after three failures in a row over all connections."""

import hmac
from collections.abc import Callable
from typing import Final

from fieldrig.clock import S

ALARM_AFTER: Final = 3
DELAY_NS: Final = 10 * S


class LoginGuard:
    """Checks the logins of one server.  `on_refused` is called with the name from the third failure in a row on."""

    def __init__(self, user_name: str, password: str, on_refused: Callable[[str], None] = lambda _: None) -> None:
        self._login = user_name.encode(), password.encode()
        self._on_refused = on_refused
        self.failures = 0

    @property
    def delay_ns(self) -> int:
        """Time by which the answer to a login is delayed."""
        return DELAY_NS if self.failures >= ALARM_AFTER else 0

    def is_right(self, user_name: str, password: str) -> bool:
        """Check a login, and count a failure."""
        wanted_name, wanted_password = self._login
        is_name_right = hmac.compare_digest(user_name.encode("utf-8", "replace"), wanted_name)
        is_right = hmac.compare_digest(password.encode("utf-8", "replace"), wanted_password) and is_name_right
        self.failures = 0 if is_right else self.failures + 1
        if self.failures >= ALARM_AFTER:
            self._on_refused(user_name)
        return is_right
