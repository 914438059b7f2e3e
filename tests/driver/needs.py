"""The needs of test parts: what the machine must provide, how to detect it, and how to install it.

Debian's packages are installed where that is allowed (root, apt-get); elsewhere the remedy is words.
"""

import os
import shutil
import subprocess
from collections.abc import Callable, Iterable, Sequence
from ctypes.util import find_library
from dataclasses import dataclass
from pathlib import Path

from tests.driver import docker_daemon, ppp, uml, vcan


@dataclass(frozen=True, slots=True)
class Need:
    name: str
    packages: tuple[str, ...]
    """The Debian packages that bring it."""
    is_met: Callable[[], bool]

    @property
    def remedy(self) -> str:
        return f"apt-get install {' '.join(self.packages)}"


def program(name: str, *packages: str) -> Need:
    """A program on the PATH; the package is called the same if not named."""
    return Need(name, packages or (name,), lambda: shutil.which(name) is not None)


CHROMIUM = program("chromium")
CAN_UTILS = program("cansend", "can-utils")
MBPOLL = program("mbpoll")
NODE = program("node", "nodejs")
SOCAT = program("socat")
TSHARK = program("tshark")
GTKWAVE = program("vcd2fst", "gtkwave")
SIGROK = program("sigrok-cli")
CHAT = program("chat", "ppp")
TNFTP = program("tnftp")
LIBMODBUS = Need(
    "libmodbus",
    ("libmodbus-dev", "gcc", "libc6-dev"),
    lambda: (
        shutil.which("gcc") is not None and find_library("modbus") is not None and Path("/usr/include/modbus").is_dir()
    ),
)
NPM = Need(
    "npm with a C++ compiler",
    ("npm", "g++", "make"),
    lambda: all(shutil.which(name) for name in ("npm", "node", "g++", "make")),
)
UML = Need("user-mode Linux", ("user-mode-linux", "kmod", "iproute2", "gcc", "libc6-dev"), uml.is_there)
VCAN = Need("a kernel with vcan", UML.packages, lambda: vcan.is_there() or uml.is_there())
PPPD = Need("pppd", ("ppp",), ppp.pppd_is_there)
DOCKER = Need("Docker with Compose", ("docker.io", "docker-compose", "debootstrap"), docker_daemon.can_be_reached)


def missing(needs: Iterable[Need]) -> list[Need]:
    return [need for need in needs if not need.is_met()]


def may_install() -> bool:
    return os.geteuid() == 0 and shutil.which("apt-get") is not None


def install(needs: Sequence[Need]) -> None:
    """Try; what is still missing afterwards is found by asking again."""
    packages = sorted({package for need in needs for package in need.packages})
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive", "NEEDRESTART_SUSPEND": "1"}
    for command in (["update"], ["install", "--yes", "--no-install-recommends", *packages]):
        subprocess.run(["apt-get", "-qq", *command], env=quiet, stdout=subprocess.DEVNULL, check=False)
