"""Addresses that tests may listen on."""

import re
import socket
from collections.abc import Mapping

_given: set[int] = set()


def free_port() -> int:
    """A TCP port of 127.0.0.1 that nobody listens on; another one at each call, for the system may give one twice."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port: int = probe.getsockname()[1]
        if port not in _given:
            _given.add(port)
            return port


def exchanged(text: str, numbers: Mapping[str, str]) -> str:
    """The text with ports exchanged for others."""
    return re.sub(rf"(?<!\d)({'|'.join(numbers)})(?!\d)", lambda match: numbers[match[0]], text)
