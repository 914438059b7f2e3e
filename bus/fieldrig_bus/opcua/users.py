"""The users of a server, who prove themselves with the token of the rig (`fieldrig.outside.shared_token`)."""

import hmac
from collections.abc import Mapping
from typing import Any, Final, Literal

from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.user_managers import UserManager

Right = Literal["read", "write"]
ANYONE: Final = "anonymous"


class Users(UserManager):  # type: ignore[misc]
    def __init__(self, rights: Mapping[str, Right], password: str | None, is_open: bool) -> None:
        """Create the users; with `is_open`, clients without a name may do everything."""
        self._rights, self._password, self._is_open = rights, password, is_open

    def get_user(
        self, iserver: Any, username: str | None = None, password: str | None = None, certificate: bytes | None = None
    ) -> User | None:
        """Return the user of a session; None refuses it."""
        if username is None:
            return User(UserRole.User, ANYONE) if self._is_open else None
        if username not in self._rights or self._password is None or password is None:
            return None
        is_right = hmac.compare_digest(password.encode(), self._password.encode())
        return User(UserRole.User, username) if is_right else None

    def may_write(self, user: User) -> bool:
        is_trusted = user.role is UserRole.Admin or user.name == ANYONE
        return bool(is_trusted or self._rights.get(user.name or "") == "write")
