"""Addresses as people write them, `host:port`, `tcp://host:port`, `[::1]:5020`, and where a rig is controlled."""

import errno
import ipaddress
from typing import Final
from urllib.parse import urlsplit

DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
"""Zenoh endpoint of a rig's control service."""
ENDPOINT: Final = r"^((tcp|udp|tls|quic|ws)/[^/\s]+:[0-9]{1,5}|unixsock-stream/\S+)$"
"""The form of an endpoint, as a regular expression."""
UNIX_SOCKET: Final = "unixsock-stream"
"""The protocol of endpoints that are Unix sockets; a path follows it."""
ENDPOINT_VARIABLE: Final = "FIELDRIG_CONTROL"
"""Environment variable that names another endpoint."""


def split_address(address: str) -> tuple[str, int]:
    """Return host and port.  ValueError, with what was expected, for anything else.  The port is 0 to 65535."""
    parts = urlsplit(address if "://" in address else f"tcp://{address}")
    try:
        port = parts.port
    except ValueError:
        port = None
    if parts.scheme != "tcp" or not parts.hostname or port is None or parts.path:
        raise ValueError(f"{address!r} is not an address: expected host:port, such as 127.0.0.1:5020")
    return parts.hostname, port


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach the host."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def bind_remedy(cause: OSError) -> str:
    """Return what to do when an address is not available for listening."""
    if cause.errno == errno.EADDRINUSE:
        return "another program, or another rig, listens there: stop it, or choose another port in the rig file"
    if cause.errno == errno.EACCES:
        return "ports below 1024 need rights: choose one above, such as 5020"
    if cause.errno == errno.EADDRNOTAVAIL:
        return "that address is not one of this machine: 127.0.0.1 always is"
    return "choose another address in the rig file"
