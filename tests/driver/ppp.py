"""Run a command inside user-mode Linux with the kernel's PPP and TUN, for tests against pppd.

It is always the guest, even where this machine's kernel has PPP: pppd reads its passwords from /etc/ppp, and what the
tests write there vanishes with the guest.
"""

import shutil
from collections.abc import Sequence
from pathlib import Path

from tests.driver import uml

MODULES = ("slhc", "crc-ccitt", "ppp_generic", "ppp_async", "tun")


def pppd_is_there() -> bool:
    return shutil.which("pppd", path=uml.SYSTEM_PATH) is not None


def command(wanted: Sequence[str], writable: Path, limit_s: float) -> list[str]:
    """The command that runs the one wanted in the guest, where `writable` keeps what it writes."""
    guest = ["--modules", " ".join(MODULES), "--setup", "true", "--seconds", f"{limit_s:g}"]
    return [*uml.PYTHON, *guest, "--writable", str(writable), "--", *wanted]
