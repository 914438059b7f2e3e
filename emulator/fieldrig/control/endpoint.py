"""Zenoh sessions for a rig's control messages, invisible to everything else on the network.

The rig listens at one endpoint and routes; processes and tools connect to it.  Scouting is off.  Beyond loopback both
ends need the same token (`shared_token`).
"""

import asyncio
import hashlib
import json
import re
import socket
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import zenoh

from fieldrig.errors import ControlError, RigError, UsageError
from fieldrig.outside.addresses import DEFAULT_ENDPOINT, ENDPOINT, ENDPOINT_VARIABLE, UNIX_SOCKET, is_loopback
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, make_token, token

OTHER_ENDPOINT: Final = "give this one another endpoint, such as --control tcp/127.0.0.1:7448"
_USER: Final = "fieldrig"
_RETRY_S: Final = 0.02
LIMITS: Final = {"transport/unicast/accept_timeout": 2_000, "transport/unicast/accept_pending": 1_000}
"""How long a connection may take to say who it is, in ms, and how many may be about to.  By Zenoh's own limits, 10 s
and 100, a hundred connections that say nothing keep every tool out."""
PATIENCE_S: Final = 10.0
"""Zenoh's own time limit, in seconds."""


class NoRigError(ControlError):
    """Nothing answers at the endpoint."""


def is_local(endpoint: str) -> bool:
    """Return whether the endpoint can only be reached from this machine."""
    protocol, _, address = endpoint.partition("/")
    if protocol == UNIX_SOCKET:
        return True
    return is_loopback(address.partition("?")[0].rpartition(":")[0].strip("[]"))


def is_guarded(endpoint: str) -> bool:
    """Return whether the endpoint can only be reached from this machine, or only with a token."""
    return is_local(endpoint) or token() is not None


def listen(endpoint: str) -> zenoh.Session:
    """Open the rig's own session.  RigError if the endpoint is taken, or would be open to everybody.

    If the token's file does not exist yet, it is made.
    """
    make_token()
    if not is_guarded(endpoint):
        raise RigError(
            f"the control endpoint {endpoint} can be reached from other machines",
            f"set a token in the environment variable {TOKEN_VARIABLE}, for the rig and for its tools,"
            f" or name a file for it in {FILE_VARIABLE}, or listen on {DEFAULT_ENDPOINT}",
        )
    try:
        return open_session({"mode": "router", "listen/endpoints": [endpoint]})
    except zenoh.ZError as cause:
        check_free(endpoint)
        reason = str(cause).partition(" at /")[0]
        raise RigError(f"cannot listen on the control endpoint {endpoint}: {reason}", OTHER_ENDPOINT) from cause


def open_session(settings: Mapping[str, Any]) -> zenoh.Session:
    """Open a session with settings of its own, such as a bus has: without scouting, and with the token if there is one.

    zenoh.ZError if that fails.  RigError if the path of a socket is taken by something else, which Zenoh would delete.
    """
    for endpoint in settings.get("listen/endpoints", ()):
        protocol, _, path = endpoint.partition("/")
        if protocol == UNIX_SOCKET:
            _check_place(Path(path))
    if settings.get("listen/endpoints"):
        settings = {**LIMITS, **settings}
    password = _password()
    if password is None or not settings.get("listen/endpoints"):
        return _open(dict(settings))
    with tempfile.TemporaryDirectory() as folder:  # Zenoh reads the passwords it accepts from a file, once
        dictionary = Path(folder) / "users"
        dictionary.write_text(f"{_USER}:{password}\n", encoding="ascii", newline="\n")
        return _open({**settings, "transport/auth/usrpwd/dictionary_file": str(dictionary)})


def _check_place(path: Path) -> None:
    """Check that nothing of others is where Zenoh makes its socket, and beside it an empty file as its lock."""
    lock = path.with_name(f"{path.name}.lock")
    try:
        is_taken = path.is_symlink() or (path.exists() and not path.is_socket())
        is_lock_taken = lock.is_symlink() or (lock.exists() and not (lock.is_file() and lock.stat().st_size == 0))
    except OSError as cause:
        raise RigError(f"{path} cannot be a socket: {cause.strerror}", OTHER_ENDPOINT) from cause
    for file in [path] * is_taken + [lock] * is_lock_taken:
        raise RigError(f"{file} is there, and does not belong to a socket of a rig", f"remove it, or {OTHER_ENDPOINT}")


def check_free(endpoint: str) -> None:
    """Check that the endpoint is free.  RigError if another program listens there."""
    if is_answered(endpoint):
        raise RigError(
            f"cannot listen on the control endpoint {endpoint}: another program listens there",
            f"stop the rig that runs (`fieldrig status` shows it, `fieldrig stop` stops it), or {OTHER_ENDPOINT}",
        )


def connect(endpoint: str, patience_s: float = PATIENCE_S) -> zenoh.Session:
    """Open the session of a process or tool.

    NoRigError if no rig answers there within the given time; UsageError for what is no endpoint.
    """
    if re.match(ENDPOINT, endpoint) is None:
        raise UsageError(f"{endpoint!r} is no endpoint", f"expected a text like {DEFAULT_ENDPOINT}")
    settings = {"mode": "client", "connect/endpoints": [endpoint]}
    try:
        return _open({**settings, "transport/unicast/open_timeout": round(patience_s * 1000)})
    except zenoh.ZError as cause:
        if is_answered(endpoint):
            raise NoRigError(
                f"the program that listens at {endpoint} refuses the connection",
                f"the rig may ask for a token: set the environment variable {TOKEN_VARIABLE} to the rig's",
            ) from cause
        raise NoRigError(
            f"no rig answers at {endpoint}",
            "start one with `fieldrig up FILE`; if one runs, name the endpoint that the first line of `up` shows, by"
            f" --control or {ENDPOINT_VARIABLE}",
        ) from cause


async def connect_patiently(endpoint: str, patience_s: float) -> zenoh.Session:
    """Do the same for a rig that may still be starting."""
    loop = asyncio.get_running_loop()
    give_up_s = loop.time() + patience_s
    while True:
        try:
            return connect(endpoint)
        except ControlError:
            if loop.time() > give_up_s:
                raise
        await asyncio.sleep(_RETRY_S)


def is_answered(endpoint: str) -> bool:
    """Return whether anything listens at the endpoint."""
    protocol, _, address = endpoint.partition("/")
    try:
        if protocol == UNIX_SOCKET:
            if not hasattr(socket, "AF_UNIX"):
                return False
            with socket.socket(socket.AF_UNIX) as line:
                line.connect(address)
            return True
        host, _, port = address.rpartition(":")
        socket.create_connection((host.strip("[]"), int(port)), timeout=1).close()
    except (OSError, ValueError):
        return False
    return True


def _password() -> str | None:
    """Return the token in the characters that Zenoh allows in its `user:password` lines."""
    secret = token()
    return None if secret is None else hashlib.sha256(secret.encode()).hexdigest()


def _open(settings: dict[str, Any]) -> zenoh.Session:
    config = zenoh.Config()
    password = _password()
    if password is not None:
        settings |= {"transport/auth/usrpwd/user": _USER, "transport/auth/usrpwd/password": password}
    settings |= {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,  # a router waits 0.5 s for others otherwise
        "timestamping/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    for name, value in settings.items():
        config.insert_json5(name, json.dumps(value))
    return zenoh.open(config)


def close(session: Any) -> None:
    """Close a session.  Zenoh's stubs give `Session.close` no types, which only this function has to know."""
    session.close()
