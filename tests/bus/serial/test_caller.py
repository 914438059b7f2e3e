"""The call of `fieldrig dial` in its event loop, at a port that a test plays."""

from collections.abc import Callable
from ipaddress import IPv4Address

import pytest

from fieldrig.errors import BusError
from fieldrig_bus.ip.stream import Opening
from fieldrig_bus.serial import caller


class FloodedPort:
    """A port at which 1000 pieces arrive before anything is read, and that is gone then."""

    def __init__(self, _url: str, _baud: int) -> None: ...

    def start(self, on_data: Callable[[bytes], None], on_gone: Callable[[str], None]) -> None:
        for _ in range(1000):
            on_data(b"ab")
        on_gone("unplugged")

    def send(self, data: bytes) -> None: ...

    def close(self) -> None: ...


class CountingSession:
    is_over = is_up = False
    peer_address = IPv4Address(0)

    def __init__(self) -> None:
        self.received: list[bytes] = []
        self.advances = 0

    def start(self, now_ns: int) -> None: ...

    def receive(self, now_ns: int, data: bytes) -> None:
        self.received.append(data)

    def next_ns(self) -> int | None:
        return None

    def advance(self, now_ns: int) -> None:
        self.advances += 1

    def open(self, port: int) -> Opening:
        raise ConnectionError

    def hang_up(self, now_ns: int) -> None: ...


def test_what_has_arrived_is_taken_at_once_also_when_the_port_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each piece by itself cost a look at the timers of all connections, and a busy call stood still."""
    monkeypatch.setattr(caller, "ThreadedPort", FloodedPort)
    session = CountingSession()
    with pytest.raises(BusError, match="unplugged"):
        caller.call("port", 9600, lambda transmit: session, [], lambda: None)
    assert (session.received, session.advances) == ([b"ab" * 1000], 1)
