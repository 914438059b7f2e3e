"""The sockets of a block do the same over both kinds of pairs: those of POSIX, and TCP as on Windows."""

import asyncio
import select
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from random import Random
from typing import Any

import pytest

from fieldrig import Rig, from_dict, virtual_time
from fieldrig.master_time import pairs

ADDRESS = ("127.0.0.1", 7000)


def exchange() -> list[Any]:
    """Send random pieces both ways, with pauses; return what each end saw, and when."""
    seen: list[Any] = []
    chance = Random(7)

    def serve() -> None:
        connection, peer = listening.accept()
        with connection:
            while data := connection.recv(chance.choice((1, 100, 5000))):
                seen.append(("server", time.monotonic(), len(data)))
                connection.sendall(data[::-1])
                time.sleep(chance.choice((0, 0.001)))
        seen.append(("peer", peer))

    with socket.create_server(ADDRESS) as listening:
        thread = threading.Thread(target=serve)
        thread.start()
        with socket.create_connection(ADDRESS, timeout=5) as line:
            for size in (1, 10, 3000, 60_000, 200_000):
                line.sendall(bytes(chance.randrange(256) for _ in range(size)))
                left = size
                while left:
                    left -= len(data := line.recv(8192))
                    seen.append(("client", time.monotonic(), hash(data)))
            line.shutdown(socket.SHUT_WR)
            assert line.recv(1) == b""
        thread.join()
    return seen


def end_before_the_data_is_read() -> list[Any]:
    """Close an end at once after it has sent; the other one still has everything."""
    with socket.create_server(ADDRESS) as listening:
        line = socket.create_connection(ADDRESS)
        line.sendall(b"x" * 100)
        line.close()
        connection, _ = listening.accept()
        with connection:
            return [connection.recv(60), connection.recv(60), connection.recv(60)]


def refused_connections() -> list[Any]:
    """Connect where no server listens, to one that does not accept, and to one that has closed."""
    found: list[Any] = []

    def attempt() -> None:
        line = socket.socket()
        found.append(line.connect_ex(ADDRESS))
        kept.append(line)

    kept: list[socket.socket] = []
    with socket.socket() as listening:
        listening.bind(ADDRESS)
        attempt()
        listening.listen(1)
        for _ in range(4):
            attempt()
        connection, _ = listening.accept()
        connection.close()
        attempt()
    attempt()
    for line in kept:
        line.close()
    return found


def many_clients_of_an_event_loop() -> list[Any]:
    """Serve twenty clients, which all connect at one instant, and end them in another order."""
    seen: list[Any] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        number = (await reader.readexactly(1))[0]
        await asyncio.sleep(0.01 * (number * 7 % 20))
        writer.write(bytes([number, number]))
        writer.close()

    async def ask(number: int) -> None:
        reader, writer = await asyncio.open_connection(*ADDRESS)
        writer.write(bytes([number]))
        seen.append((await reader.read(), time.monotonic()))
        writer.close()

    async def all_of_them() -> None:
        async with await asyncio.start_server(serve, *ADDRESS):
            await asyncio.gather(*map(ask, range(20)))

    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
        runner.run(all_of_them())
    return seen


class LateTcp:
    """A network that delivers each piece some milliseconds later, in a thread of real time."""

    def __init__(self) -> None:
        self._real_pair = pairs._pair
        self._ways: list[tuple[Any, Any]] = []
        self._is_over = False
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def pair(self) -> tuple[Any, Any]:
        (near, one), (other, far) = self._real_pair(), self._real_pair()
        self._ways += [(one, other), (other, one)]
        return near, far

    def close(self) -> None:
        self._is_over = True
        self._thread.join()

    def _carry(self) -> None:
        ended: set[tuple[Any, Any]] = set()
        while not self._is_over:
            time.sleep(0.002)
            for way in [way for way in self._ways if way not in ended]:
                if select.select([way[0]], [], [], 0)[0] and not self._carried(*way):
                    ended.add(way)
        for source, _ in self._ways:
            source.close()

    def _carried(self, source: Any, target: Any) -> bool:
        """Carry what has come; return False if that was the end, which is carried as well."""
        with suppress(OSError):  # an end that was closed with unread data
            if data := source.recv(65536):
                target.sendall(data)
                return True
            target.shutdown(socket.SHUT_WR)
        return False


@pytest.mark.long
@pytest.mark.timeout(60)
@pytest.mark.parametrize(
    "program", [exchange, end_before_the_data_is_read, refused_connections, many_clients_of_an_event_loop]
)
def test_a_program_sees_the_same_over_both_kinds_of_pairs(
    program: Callable[[], list[Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def played() -> list[Any]:
        with Rig(from_dict({"time": "virtual", "buses": {}, "devices": {}})) as rig, virtual_time(rig):
            return program()

    expected = played()
    assert expected
    monkeypatch.setattr(pairs, "IS_INSTANT", False)
    assert played() == expected
    late = LateTcp()
    monkeypatch.setattr(pairs, "_pair", late.pair)
    try:
        assert played() == expected
    finally:
        late.close()
