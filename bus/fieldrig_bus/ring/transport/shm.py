"""`ring.shm`: the fibre ring in real time over shared memory, for short cycles with a process per drive (Linux).

The centre writes each cycle into one image and wakes every process by an eventfd, which the loop there waits for; the
processes write their ATs into images of their own, where the centre finds them at the next MST: nobody is woken for
them.  Images and eventfds are handed over a Unix socket in the run folder (SCM_RIGHTS), which also tells who is there:
its end is the end of the process.
"""

import asyncio
import json
import logging
import os
import socket
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, Final

from fieldrig.bus import Attachment
from fieldrig.errors import BusError
from fieldrig.untrusted import read_json
from fieldrig_bus.ring.transport.centre import Centre
from fieldrig_bus.ring.transport.image import Image
from fieldrig_bus.ring.transport.rack import Rack
from fieldrig_bus.ring.transport.wire import Stations

log = logging.getLogger(__name__)

LONGEST_OUT: Final = 16 * 1024
LONGEST_BACK: Final = 8 * 1024
LONGEST_WORD: Final = 64 * 1024
"""Of what a process says of its stations."""
RETRY_S: Final = 0.02
_ONE: Final = (1).to_bytes(8, "little")
_NEEDS = "it needs Linux; use ring.zenoh elsewhere"


def is_available() -> bool:
    return hasattr(os, "memfd_create") and hasattr(os, "eventfd") and hasattr(socket, "SOCK_SEQPACKET")


class _Peer:
    """One process, at the centre."""

    def __init__(
        self, sock: socket.socket, on_word: Callable[["_Peer", Any], None], loop: asyncio.AbstractEventLoop
    ) -> None:
        self.socket = sock
        self.who: str | None = None
        self.back = Image.make("fieldrig-back", LONGEST_BACK)
        self.bell = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._on_word, self._loop = on_word, loop
        sock.setblocking(False)
        loop.add_reader(sock, self._on_readable)

    def _on_readable(self) -> None:
        try:
            word = self.socket.recv(LONGEST_WORD)
            self._on_word(self, read_json(word) if word else None)
        except BlockingIOError:
            return
        except (OSError, ValueError) as fault:
            log.debug("%s: %s", self.who, fault)
            self._on_word(self, None)

    def close(self) -> None:
        self._loop.remove_reader(self.socket)
        self.socket.close()
        self.back.close()
        os.close(self.bell)


class ShmSpokes:
    """The centre's end.  BusError if the socket can't be had."""

    def __init__(self, path: Path, centre: Centre) -> None:
        self._path, self._centre = path, centre
        self._image = Image.make("fieldrig-ring", LONGEST_OUT)
        self._peers: dict[str, _Peer] = {}
        self._strangers: set[_Peer] = set()
        self._loop = centre.loop
        self._door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._door.setblocking(False)
        try:
            _take_address(self._door, path)
        except OSError as cause:
            self._door.close()
            self._image.close()
            raise BusError(f"the ring's socket {path} can't be had: {cause}", "give the rig another `run`") from cause
        self._loop.add_reader(self._door, self._on_knock)

    def spread(self, message: bytes, hung: Collection[str]) -> None:
        try:
            self._image.write(message)
        except ValueError as fault:
            log.warning("%s: %s", self._path.name, fault)
            return
        for who, peer in self._peers.items():
            if who not in hung:
                os.write(peer.bell, _ONE)

    def gather(self) -> Iterator[tuple[str, bytes]]:
        for who, peer in self._peers.items():
            for message in peer.back.read():
                yield who, message

    def close(self) -> None:
        self._loop.remove_reader(self._door)
        self._door.close()
        self._path.unlink(missing_ok=True)
        for peer in (*self._strangers, *self._peers.values()):
            peer.close()
        self._strangers.clear()
        self._peers.clear()
        self._image.close()

    def _on_knock(self) -> None:
        try:
            sock, _ = self._door.accept()
        except OSError as fault:
            log.debug("%s: %s", self._path.name, fault)
            return
        self._strangers.add(_Peer(sock, self._on_word, self._loop))

    def _on_word(self, peer: _Peer, word: Any) -> None:
        match word:
            case {"process": str(who), "stations": list(stations)} if peer.who in (None, who) and _are(stations):
                if peer.who is None:
                    self._greet(peer, who)
                self._centre.announce(who, [(name, addresses) for name, addresses in stations])
            case _:
                self._lose(peer)

    def _greet(self, peer: _Peer, who: str) -> None:
        former = self._peers.pop(who, None)
        if former is not None:  # its end has not been noticed yet
            self._centre.lose(who)
            former.close()
        peer.who = who
        self._strangers.discard(peer)
        self._peers[who] = peer
        number = self._image.number.to_bytes(4, "little")
        socket.send_fds(peer.socket, [number], [self._image.fd, peer.back.fd, peer.bell])

    def _lose(self, peer: _Peer) -> None:
        self._strangers.discard(peer)
        if peer.who is not None and self._peers.get(peer.who) is peer:
            del self._peers[peer.who]
            self._centre.lose(peer.who)
        peer.close()


class ShmLine:
    """A process's way to the centre."""

    def __init__(self, path: Path, process: str, rack: Rack[Any]) -> None:
        self._path, self._process, self._rack = path, process, rack
        self._loop = rack.loop
        self._socket: socket.socket | None = None
        self._images: tuple[Image, Image] | None = None
        self._bell: int | None = None
        self._retry: asyncio.TimerHandle | None = None
        self._connect()

    def close(self) -> None:
        if self._retry is not None:
            self._retry.cancel()
        self._hang_up()

    def _connect(self) -> None:
        self._retry = None
        sock = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        sock.setblocking(False)
        try:
            sock.connect(str(self._path))
        except OSError:
            sock.close()
            self._retry = self._loop.call_later(RETRY_S, self._connect)
            return
        self._socket = sock
        self._loop.add_reader(sock, self._on_readable)
        self._rack.connect(self._announce, self._reply)

    def _announce(self, stations: Stations) -> None:
        assert self._socket is not None
        word = json.dumps({"process": self._process, "stations": stations}).encode()
        try:
            self._socket.send(word)
        except OSError as fault:  # its end comes to `_on_readable`
            log.debug("%s: %s", self._path.name, fault)

    def _reply(self, message: bytes) -> None:
        if self._images is None:
            return
        try:
            self._images[1].write(message)
        except ValueError as fault:
            log.warning("%s: %s", self._process, fault)

    def _on_readable(self) -> None:
        assert self._socket is not None
        try:
            word, fds, _, _ = socket.recv_fds(self._socket, 64, 3)
        except BlockingIOError:
            return
        except OSError:
            word, fds = b"", []
        if self._images is None and len(word) == 4 and len(fds) == 3:
            self._images, self._bell = (Image(fds[0]), Image(fds[1])), fds[2]
            self._images[0].number = int.from_bytes(word, "little")
            self._loop.add_reader(self._bell, self._on_bell)
            return
        for fd in fds:
            os.close(fd)
        if not word:
            self._hang_up()
            self._retry = self._loop.call_later(RETRY_S, self._connect)

    def _on_bell(self) -> None:
        assert self._bell is not None
        try:
            os.read(self._bell, 8)
        except BlockingIOError:
            return
        images = self._images
        if images is not None:
            for message in images[0].read():
                self._rack.on_spread(message)
                if self._images is not images:  # a drive has closed the line
                    return

    def _hang_up(self) -> None:
        self._rack.disconnect()
        if self._socket is not None:
            self._loop.remove_reader(self._socket)
            self._socket.close()
            self._socket = None
        if self._bell is not None:
            self._loop.remove_reader(self._bell)
            os.close(self._bell)
            self._bell = None
        if self._images is not None:
            for image in self._images:
                image.close()
            self._images = None


class ShmCarrier:
    """Connects the processes of one ring over shared memory.  BusError where the system has none."""

    def __init__(self, name: str) -> None:
        """`name` is that of the bus."""
        self.name = name
        if not is_available():
            raise BusError(f"{name}: this system has no memfd and eventfd", _NEEDS)

    def reach(self, at: Attachment, rack: Rack[Any]) -> ShmLine:
        return ShmLine(self._path(at), at.process, rack)

    def hold(self, at: Attachment, centre: Centre) -> ShmSpokes:
        return ShmSpokes(self._path(at), centre)

    def _path(self, at: Attachment) -> Path:
        return at.path(f"{self.name}.ring")


def _are(stations: list[Any]) -> bool:
    for station in stations:
        match station:
            case [str(), None]:
                continue
            case [str(), list(addresses)] if all(isinstance(address, int) for address in addresses):
                continue
            case _:
                return False
    return True


def _take_address(door: socket.socket, path: Path) -> None:
    """The rig's lock says that no living rig owns the folder; but another master of this rig may be there."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
        else:
            raise OSError("another process of this rig is its master")
    door.bind(str(path))
    door.listen(64)
