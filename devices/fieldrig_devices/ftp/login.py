"""The login of FTP: one user."""

from collections.abc import Callable

from fieldrig_devices.logins.guard import LoginGuard


class FtpLogin:
    """Checks the logins of one server.  `on_refused` is called with the name while the guard is alarmed."""

    def __init__(self, user_name: str, password: str, on_refused: Callable[[str], None] = lambda _: None) -> None:
        self._wanted = (user_name.encode(), password.encode())
        self._on_refused = on_refused
        self._guard = LoginGuard()

    @property
    def delay_ns(self) -> int:
        """Time by which the answer to a login is delayed."""
        return self._guard.delay_ns

    def is_right(self, user_name: str, password: str) -> bool:
        """Check a login, and count a failure."""
        given = user_name.encode("utf-8", "replace"), password.encode("utf-8", "replace")
        is_right = self._guard.is_right(given, self._wanted)
        if self._guard.is_alarmed:
            self._on_refused(user_name)
        return is_right
