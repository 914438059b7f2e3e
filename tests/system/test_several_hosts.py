"""A rig over two hosts, as docs/operate/several-hosts.md says, with a line between them that is slow, lossy and cut."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import forked_cli
import network_namespace
import pytest
from doc_pages import ROOT, blocks, page_named
from network_namespace import inside
from patience import PATIENCE_S
from process_group import kill_group
from two_hosts import Host, Line, two_hosts

from fieldrig.outside.page_seat import NO_PAGE_VARIABLE

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]

PAGE: Final = page_named("several-hosts.md")
CONTROL: Final = "tcp/10.77.0.1:7450"
MISSING: Final = (2560, 2561)
"""The diagnosis: the ring is open, a drive telegram is missing."""
FAR: Final = {"panel", "infeed", "film", "jaw", "jaw_encoder", "outfeed"}
"""The processes of the second host."""


class Rig:
    """The rig of the page, seen from the host of its controller."""

    def __init__(self, near: Host, far: Host, folder: Path, scripts: "Sequence[subprocess.Popen[bytes]]") -> None:
        self.near, self.far, self.folder, self.scripts = near, far, folder, scripts
        self.commands = forked_cli.Server()

    def tool(self, *words: str) -> str:
        arguments = (*words, "--control", CONTROL)
        with inside(self.near.network):
            done = forked_cli.run(arguments, self.folder, os.environ, limit_s=PATIENCE_S, server=self.commands)
        return done.stdout if done.returncode == 0 else ""

    def until_ready(self) -> None:
        """Wait until the rig is ready."""
        self.until(lambda: self.status()["state"] == "ready")

    def until(self, is_so: Callable[[], bool]) -> None:
        """Wait for a condition.  What the rig and its processes have said is in the message if it never comes."""
        give_up_s = time.monotonic() + PATIENCE_S
        while not is_so():
            is_late = time.monotonic() > give_up_s or any(script.poll() is not None for script in self.scripts)
            assert not is_late, self._all_said()

    def _all_said(self) -> str:
        logs = (self.log(name) for name in ("controller-host", "drive-host"))
        return "\n".join((str(self.status()), self.tool("get", "max4"), *logs))

    def status(self) -> dict[str, Any]:
        """Return nothing while the control service waits for those that are cut off."""
        told = self.tool("status", "--json")
        return json.loads(told) if told else {"state": "", "processes": {}, "buses": {}}

    def get(self, point: str) -> Any:
        told = self.tool("get", point, "--json")
        return json.loads(told)[point] if told else None

    @property
    def ring_closed(self) -> float | None:
        """The figure of the ring; None while its process does not answer in time."""
        closed: float | None = self.status()["buses"].get("ring", {}).get("statistics", {}).get("ring_closed")
        return closed

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.out").read_text(encoding="utf-8")


@contextmanager
def running(near: Host, far: Host, folder: Path) -> Iterator[Rig]:
    """Start the scripts of the page on both hosts, which have no folder in common."""
    scripts = list["subprocess.Popen[bytes]"]()
    with ExitStack() as stack:
        for host, script in ((near, "controller-host"), (far, "drive-host")):
            own = folder / script
            own.mkdir()
            (own / "configs").symlink_to(ROOT / "configs")
            for block in blocks(PAGE):
                if block.info[1:2] in (("file",), ("rig",)):
                    (own / block.info[2]).write_text(block.text, encoding="utf-8")
            scripts.append(host.start(["sh", f"{script}.sh"], own, folder / f"{script}.out"))
            stack.callback(_end, scripts[-1])
        rig = Rig(near, far, folder, scripts)
        stack.callback(rig.commands.end)
        yield rig


def _end(process: "subprocess.Popen[bytes]") -> None:
    os.killpg(process.pid, signal.SIGTERM)
    process.wait(60)
    kill_group(process.pid)  # a process that is cut off waits for the other host


@pytest.fixture
def hosts(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Rig, Line]]:
    if why := network_namespace.why_not():
        pytest.skip(why)
    monkeypatch.setenv("FIELDRIG_TOKEN", "known to both hosts")
    monkeypatch.setenv(NO_PAGE_VARIABLE, "1")
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    with (
        TemporaryDirectory(prefix="hosts") as folder,  # short, as Unix sockets require
        two_hosts() as (near, far, line),
        running(near, far, Path(folder)) as rig,
    ):
        rig.until_ready()
        yield rig, line


def test_a_cut_between_two_hosts_is_reported_on_both_and_the_rig_comes_back(hosts: tuple[Rig, Line]) -> None:
    rig, line = hosts
    line.delay(1.0)
    looked = rig.far.run(["sh", "look.sh"], rig.folder / "drive-host")
    assert looked.returncode == 0, looked.stderr
    rig.until(lambda: rig.get("max4/ring.phase") == 4)
    rig.until(lambda: rig.ring_closed == 1)

    line.cut()
    rig.until(lambda: all(rig.status()["processes"].get(name, {}).get("state") == "dead" for name in FAR))
    assert rig.status()["state"] == "degraded"
    rig.until(lambda: rig.ring_closed == 0)
    assert any(f"diagnosis {code}" in rig.log("controller-host") for code in MISSING)
    assert "diagnosis 2112" in rig.log("drive-host"), "a drive sees that the master is silent"
    rig.until(lambda: "wires: the hub is gone" in rig.log("controller-host"))

    line.mend()
    line.loss(0.5)
    rig.until_ready()
    rig.until(lambda: rig.ring_closed == 1)
    assert all(one["restarts"] == 0 for one in rig.status()["processes"].values())
    assert rig.tool("set", "jaw/mains=false")
    rig.until(lambda: rig.get("max4/I_bReadyJaw.Value") is False)  # over the wires
