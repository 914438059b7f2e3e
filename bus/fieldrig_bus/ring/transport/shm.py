"""A ring over shared memory, for short cycles with a process per station (Linux).

The centre writes each cycle into one image and wakes every process by an eventfd that its event loop waits for.  The
processes write their telegrams into images of their own, where the centre finds them at the next cycle without being
woken.  Images and eventfds are passed over a Unix socket in the run folder (SCM_RIGHTS).  The socket also announces the
stations of a process; when it closes, the process is gone.
"""

import asyncio
import json
import logging
import os
import socket
import sys
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, Final

from fieldrig.errors import BusError
from fieldrig.outside.untrusted import read_json
from fieldrig.system.own_files import remove_socket
from fieldrig_bus.ring.transport.centre import Centre
from fieldrig_bus.ring.transport.image import Image
from fieldrig_bus.ring.transport.rack import Rack
from fieldrig_bus.ring.transport.wire import Stations

assert sys.platform == "linux", "only Linux has memfd and eventfd"

log = logging.getLogger(__name__)

LONGEST_OUT: Final = 32 * 1024
LONGEST_BACK: Final = 32 * 1024
LONGEST_WORD: Final = 64 * 1024
"""Largest announcement of a process's stations, in bytes."""
RETRY_S: Final = 0.02
_WAKE: Final = (1).to_bytes(8, "little")


class _Peer:
    """One process, as the centre sees it."""

    def __init__(
        self, sock: socket.socket, on_word: Callable[["_Peer", Any], None], loop: asyncio.AbstractEventLoop, slots: int
    ) -> None:
        self.socket = sock
        self.process: str | None = None
        self.back = Image.make("fieldrig-back", LONGEST_BACK, slots)
        self.wakeup = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
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
            log.debug("%s: %s", self.process, fault)
            self._on_word(self, None)

    def close(self) -> None:
        self._loop.remove_reader(self.socket)
        self.socket.close()
        self.back.close()
        os.close(self.wakeup)


class ShmSpokes:
    """The centre's end.  BusError if the socket is not available."""

    def __init__(self, path: Path, centre: Centre, slots: int) -> None:
        self._path, self._centre, self._slots = path, centre, slots
        self._image = Image.make("fieldrig-ring", LONGEST_OUT, slots)
        self._peers: dict[str, _Peer] = {}
        self._unnamed: set[_Peer] = set()
        self._loop = centre.loop
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._listener.setblocking(False)
        try:
            _take_address(self._listener, path)
        except OSError as cause:
            self._listener.close()
            self._image.close()
            raise BusError(
                f"the ring's socket {path} is not available: {cause}", "give the rig another `run`"
            ) from cause
        self._loop.add_reader(self._listener, self._on_connection)

    def spread(self, message: bytes, hung: Collection[str]) -> None:
        try:
            self._image.write(message)
        except ValueError as fault:
            log.warning("%s: %s", self._path.name, fault)
            return
        for process, peer in self._peers.items():
            if process not in hung:
                os.write(peer.wakeup, _WAKE)

    def gather(self) -> Iterator[tuple[str, bytes]]:
        for process, peer in self._peers.items():
            for message in peer.back.read():
                yield process, message

    def close(self) -> None:
        self._loop.remove_reader(self._listener)
        self._listener.close()
        remove_socket(self._path)
        for peer in (*self._unnamed, *self._peers.values()):
            peer.close()
        self._unnamed.clear()
        self._peers.clear()
        self._image.close()

    def _on_connection(self) -> None:
        try:
            sock, _ = self._listener.accept()
        except OSError as fault:
            log.debug("%s: %s", self._path.name, fault)
            return
        self._unnamed.add(_Peer(sock, self._on_word, self._loop, self._slots))

    def _on_word(self, peer: _Peer, word: Any) -> None:
        match word:
            case {"process": str(process), "stations": list(stations)} if peer.process in (None, process) and _are(
                stations
            ):
                if peer.process is None:
                    self._admit(peer, process)
                self._centre.announce(process, [(name, addresses) for name, addresses in stations])
            case _:
                self._lose(peer)

    def _admit(self, peer: _Peer, process: str) -> None:
        former = self._peers.pop(process, None)
        if former is not None:  # its disconnection has not been noticed yet
            self._centre.lose(process)
            former.close()
        peer.process = process
        self._unnamed.discard(peer)
        self._peers[process] = peer
        number = self._image.number.to_bytes(4, "little")
        socket.send_fds(peer.socket, [number], [self._image.fd, peer.back.fd, peer.wakeup])

    def _lose(self, peer: _Peer) -> None:
        self._unnamed.discard(peer)
        if peer.process is not None and self._peers.get(peer.process) is peer:
            del self._peers[peer.process]
            self._centre.lose(peer.process)
        peer.close()


class ShmLine:
    """A process's connection to the centre."""

    def __init__(self, path: Path, process: str, rack: Rack[Any], slots: int) -> None:
        self._path, self._process, self._rack, self._slots = path, process, rack, slots
        self._loop = rack.loop
        self._socket: socket.socket | None = None
        self._images: tuple[Image, Image] | None = None
        self._wakeup: int | None = None
        self._retry: asyncio.TimerHandle | None = None
        self._connect()

    def close(self) -> None:
        if self._retry is not None:
            self._retry.cancel()
        self._disconnect()

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
        except OSError as fault:  # `_on_readable` handles the disconnection
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
            self._images, self._wakeup = (Image(fds[0], self._slots), Image(fds[1], self._slots)), fds[2]
            self._images[0].number = int.from_bytes(word, "little")
            self._loop.add_reader(self._wakeup, self._on_wakeup)
            return
        for fd in fds:
            os.close(fd)
        if not word:
            self._disconnect()
            self._retry = self._loop.call_later(RETRY_S, self._connect)

    def _on_wakeup(self) -> None:
        assert self._wakeup is not None
        try:
            os.read(self._wakeup, 8)
        except BlockingIOError:
            return
        images = self._images
        if images is not None:
            for message in images[0].read():
                self._rack.on_spread(message)
                if self._images is not images:  # a drive has closed the line
                    return

    def _disconnect(self) -> None:
        self._rack.disconnect()
        if self._socket is not None:
            self._loop.remove_reader(self._socket)
            self._socket.close()
            self._socket = None
        if self._wakeup is not None:
            self._loop.remove_reader(self._wakeup)
            os.close(self._wakeup)
            self._wakeup = None
        if self._images is not None:
            for image in self._images:
                image.close()
            self._images = None


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


def _take_address(listener: socket.socket, path: Path) -> None:
    """Listen at `path`.  The rig's lock excludes other rigs in this folder, but not another master of this rig."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
        else:
            raise OSError("another process of this rig is its master")
    listener.bind(str(path))
    listener.listen(64)
