"""A line between two networks: `slow_line.py NETWORK NETWORK`, each a descriptor of a network namespace.

It makes the TUN device `line` in each, and passes IP packets from one to the other.  Lines on standard input change it:
`delay MS`, `loss PERCENT`, `cut`, `mend`; each is answered by `done`.  It ends with its standard input.
"""

import ctypes
import fcntl
import heapq
import os
import random
import select
import struct
import sys
import time
from contextlib import suppress

_CLONE_NEWNET = 0x4000_0000
_TUNSETIFF = 0x400454CA
_IFF_TUN, _IFF_NO_PI = 0x0001, 0x1000
_LONGEST = 65_536


def tun_in(network: int) -> int:
    """Move into a network, and return the descriptor of a new TUN device there."""
    if ctypes.CDLL(None, use_errno=True).setns(network, _CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "setns")
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, _TUNSETIFF, struct.pack("16sH22x", b"line", _IFF_TUN | _IFF_NO_PI))
    return device


class Line:
    def __init__(self, one: int, other: int) -> None:
        self._across = {one: other, other: one}
        self._delay_s, self._loss, self._is_cut = 0.0, 0.0, False
        self._dice = random.Random(1)
        self._under_way: list[tuple[float, int, int, bytes]] = []
        self._count = 0

    def run(self) -> None:
        commands = sys.stdin.fileno()
        while True:
            due_s = max(0.0, self._under_way[0][0] - time.monotonic()) if self._under_way else None
            ready, _, _ = select.select([*self._across, commands], [], [], due_s)
            for device in self._across:
                if device in ready:
                    self._take(device)
            if commands in ready and not self._obey():
                return
            self._deliver()

    def _take(self, device: int) -> None:
        while True:
            try:
                packet = os.read(device, _LONGEST)
            except BlockingIOError:
                return
            if not self._is_cut and self._dice.random() >= self._loss:
                self._count += 1  # packets of the same instant stay in their order
                due = time.monotonic() + self._delay_s, self._count, self._across[device], packet
                heapq.heappush(self._under_way, due)

    def _deliver(self) -> None:
        while self._under_way and self._under_way[0][0] <= time.monotonic():
            _, _, device, packet = heapq.heappop(self._under_way)
            with suppress(OSError):  # its device is not up yet, or its queue is full: the packet is lost
                os.write(device, packet)

    def _obey(self) -> bool:
        words = sys.stdin.readline().split()
        match words:
            case ["delay", ms]:
                self._delay_s = float(ms) / 1000
            case ["loss", percent]:
                self._loss = float(percent) / 100
            case ["cut"]:
                self._is_cut = True
                self._under_way.clear()
            case ["mend"]:
                self._is_cut = False
            case _:
                return False
        print("done", flush=True)  # noqa: T201
        return True


if __name__ == "__main__":
    Line(*(tun_in(int(number)) for number in sys.argv[1:])).run()
