"""A network of its own for a test and the programs that it starts: loopback, and nothing that leads out of it."""

import ctypes
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import cache
from ipaddress import ip_address
from pathlib import Path
from sys import byteorder

_CLONE_NEWNET = 0x4000_0000
_LISTEN = "0A"
_OWN = Path("/proc/thread-self/ns/net")
_libc = ctypes.CDLL(None, use_errno=True)


@cache
def why_not() -> str:
    """The reason why this process may not have such a network with TUN devices, or an empty text."""
    if not hasattr(os, "geteuid") or os.geteuid() != 0:
        return "a network of its own needs root"
    if not Path("/dev/net/tun").exists():
        return "this kernel has no /dev/net/tun"
    if shutil.which("ip") is None or shutil.which("unshare") is None:
        return "ip or unshare is missing: apt-get install iproute2 util-linux"
    is_allowed = subprocess.run(["unshare", "-n", "true"], capture_output=True, check=False).returncode == 0
    return "" if is_allowed else "this container may not make a network of its own"


@contextmanager
def network_namespace() -> Iterator[Callable[[], AbstractContextManager[None]]]:
    """Move the calling thread, and what it starts, into a new network.

    The value returns a context in which the thread is in the network from before.
    """
    with _present() as before:
        _checked(_libc.unshare(_CLONE_NEWNET))
        try:
            subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
            yield lambda: inside(before)
        finally:
            _checked(_libc.setns(before, _CLONE_NEWNET))


@contextmanager
def new_network() -> Iterator[int]:
    """Return a descriptor of a new network, for `inside`; the calling thread stays where it is."""
    with ExitStack() as kept:
        with network_namespace():
            network = kept.enter_context(_present())
        yield network


@contextmanager
def inside(network: int) -> Iterator[None]:
    """Move the calling thread, and what it starts, into a network."""
    with _present() as before:
        _checked(_libc.setns(network, _CLONE_NEWNET))
        try:
            yield
        finally:
            _checked(_libc.setns(before, _CLONE_NEWNET))


@contextmanager
def _present() -> Iterator[int]:
    """A descriptor of the calling thread's network."""
    network = os.open(_OWN, os.O_RDONLY)
    try:
        yield network
    finally:
        os.close(network)


def _checked(result: int) -> None:
    if result != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def devices() -> set[str]:
    """Names of the network devices in the calling thread's network."""
    done = subprocess.run(["ip", "-brief", "address"], capture_output=True, text=True, check=True)
    return {line.split()[0] for line in done.stdout.splitlines()}


def addresses() -> str:
    """The IPv4 addresses in the calling thread's network, as `ip` prints them."""
    return subprocess.run(["ip", "-4", "address"], capture_output=True, text=True, check=True).stdout


def routes() -> list[str]:
    done = subprocess.run(["ip", "-4", "route"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def listening() -> set[str]:
    """The addresses at which programs in the calling thread's network listen for TCP."""
    found: set[str] = set()
    for table in ("tcp", "tcp6"):
        rows = Path(f"/proc/thread-self/net/{table}").read_text(encoding="utf-8").splitlines()[1:]
        places = [row.split()[1].partition(":")[0] for row in rows if row.split()[3] == _LISTEN]
        found |= {_shown(bytes.fromhex(place)) for place in places}
    return found


def _shown(words: bytes) -> str:
    """The address of a row, whose words have the byte order of the host."""
    parts = [words[at : at + 4] for at in range(0, len(words), 4)]
    ordered = b"".join(part[::-1] if byteorder == "little" else part for part in parts)
    return str(ip_address(ordered))
