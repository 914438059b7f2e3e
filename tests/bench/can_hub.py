"""The CAN hub: a full bus of 1 Mbit/s with 8 node processes, SDO round trips paced and unpaced, CPU of everybody.

The limits are those of the line itself: bit rate over the exact bits of the frames that were sent.  The peer for
unpaced SDO is python canopen's LocalNode behind python-can's udp_multicast, in a network namespace of its own.
"""

import asyncio
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import uvloop
from report import COMPARED, Report, progress

from fieldrig.bus import Delivery
from fieldrig.hub.attach import attach
from fieldrig.hub.hub import LocalHub
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.hub import CanHub, CanHubSettings
from fieldrig_bus.can.length import classical_bits

SECONDS = 3.0
BITRATE = 1_000_000
WINDOW = 16  # frames that a busy node keeps asked for
EDS = Path(__file__).parents[2] / "configs/eds/io32.eds"
SDO_READ = bytes.fromhex("40 00 10 00 00 00 00 00")  # upload of 1000h:00h
SDO_VALUE = bytes.fromhex("43 00 10 00 91 01 07 00")


class Hub:
    """A hub in this process, and the processes that attach to it: `script` run with the words of `be_member`."""

    script = __file__

    def __init__(self, bitrate: int | None) -> None:
        self.clock = RealClock(asyncio.get_running_loop())
        self.folder = tempfile.TemporaryDirectory(prefix="fieldrig-")
        self.run = Path(self.folder.name)
        self.bus = CanHub("can0", CanHubSettings(bitrate=bitrate))
        self.frames: list[CanFrame] = []
        self.hub = LocalHub(self.bus, self.clock, self.run)
        self.hub.on_delivery(self._on_delivery)
        self.members: list[asyncio.subprocess.Process] = []

    def _on_delivery(self, delivery: Delivery[CanFrame]) -> None:
        self.frames.append(delivery.message)

    async def start(self, *members: tuple[Any, ...]) -> None:
        await self.hub.open()
        for member in members:
            arguments = [str(self.run), "null" if self.bus.settings.bitrate is None else str(BITRATE)]
            process = await asyncio.create_subprocess_exec(
                sys.executable, self.script, *arguments, *map(str, member),
                stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            )  # fmt: skip
            self.members.append(process)
        for process in self.members:
            assert process.stdout is not None
            await process.stdout.readline()  # it is attached

    async def go(self) -> list[dict[str, float]]:
        """Let the members act for SECONDS; what each reports."""
        for process in self.members:
            assert process.stdin is not None
            process.stdin.write(b"go\n")
        reports = []
        for process in self.members:
            output, _ = await process.communicate()
            reports.append(json.loads(output))
        await self.hub.close()
        self.clock.close()
        self.folder.cleanup()
        return reports

    def line_limit(self) -> float:
        """Frames a second that the line can carry of the frames that were sent."""
        sample = self.frames[:10_000]
        return BITRATE * len(sample) / sum(map(classical_bits, sample))


class Member:
    """One attached process: acts from "go" for SECONDS, then reports what it counted and its share of a core."""

    def __init__(self, link: Link[CanFrame]) -> None:
        self.link, self.count = link, 0

    def begin(self) -> None:
        """The word to act."""


class Busy(Member):
    """Keeps the bus full: sends the next frame for each one confirmed."""

    def __init__(self, link: Link[CanFrame], identifier: int) -> None:
        super().__init__(link)
        self._identifier = identifier
        link.on_receive(self._on_sent, ["own"])

    def begin(self) -> None:
        for _ in range(WINDOW):
            self._send()

    def _send(self) -> None:
        self.link.send(CanFrame(self._identifier, (self.count * 0x9E3779B97F4A7C15 % (1 << 64)).to_bytes(8, "big")))

    def _on_sent(self, _frame: CanFrame) -> None:
        self.count += 1
        self._send()


class Bystander(Member):
    def __init__(self, link: Link[CanFrame]) -> None:
        super().__init__(link)
        link.on_receive(self._on_frame, [[0x7FF, 0x7FF]])

    def _on_frame(self, _frame: CanFrame) -> None:
        self.count += 1


class SdoClient(Member):
    """One expedited upload after the other."""

    def __init__(self, link: Link[CanFrame]) -> None:
        super().__init__(link)
        link.on_receive(self._on_response, [[0x585, 0x7FF]])

    def begin(self) -> None:
        self.link.send(CanFrame(0x605, SDO_READ))

    def _on_response(self, frame: CanFrame) -> None:
        assert frame.data[0] == SDO_VALUE[0]
        self.count += 1
        self.begin()


def sdo_server(link: Link[CanFrame], clock: RealClock, eds: str) -> Member:
    """Our CANopen node, as the lab runs it."""
    from fieldrig.storage.store import MemoryStore
    from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings

    settings = CanopenSettings.model_validate({"node_id": 5, "eds": eds}, context={"folder": "."})
    CanopenNode(clock, "io", link, settings, MemoryStore()).start()
    return Member(link)


ROLES: dict[str, Callable[..., Member]] = {
    "busy": lambda link, clock, identifier: Busy(link, int(identifier)),
    "bystander": lambda link, clock: Bystander(link),
    "client": lambda link, clock: SdoClient(link),
    "server": sdo_server,
}


async def be_member(run: str, bitrate: str, role: str, name: str, *arguments: str) -> None:
    loop = asyncio.get_running_loop()
    clock = RealClock(loop)
    bus = CanHub("can0", CanHubSettings(bitrate=json.loads(bitrate)))
    link = await attach(bus, name, clock, Path(run), lambda why: None)
    member = ROLES[role](link, clock, *arguments)
    print("attached", flush=True)
    await loop.run_in_executor(None, sys.stdin.readline)
    cpu_s = time.process_time()
    clock.handle(member.begin)
    await asyncio.sleep(SECONDS)
    print(json.dumps({"count": member.count, "cpu_percent": 100 * (time.process_time() - cpu_s) / SECONDS}))
    await link.close()
    clock.close()


async def full_bus() -> tuple[float, float, dict[str, float]]:
    """Frames a second, the line's limit, CPU per cent of hub, busy node and bystander."""
    hub = Hub(BITRATE)
    await hub.start(*(("busy", f"node{number}", 0x180 + number) for number in range(8)), ("bystander", "bystander"))
    cpu_s, start_s = time.process_time(), time.monotonic()
    reports = await hub.go()
    spent_s = time.process_time() - cpu_s
    busy = reports[:8]
    cpu = {
        "hub": 100 * spent_s / (time.monotonic() - start_s),
        "busy node": sum(report["cpu_percent"] for report in busy) / 8,
        "bystander": reports[8]["cpu_percent"],
    }
    return sum(report["count"] for report in busy) / SECONDS, hub.line_limit(), cpu


async def sdo(bitrate: int | None, *, in_hub: bool = False) -> tuple[float, float]:
    """Round trips a second, and the line's limit; the node in a process of its own, or in the hub's (`process:`)."""
    hub = Hub(bitrate)
    servers = [] if in_hub else [("server", "io", EDS)]
    if in_hub:
        sdo_server(hub.hub.join("io"), hub.clock, str(EDS))
    await hub.start(*servers, ("client", "master"))
    reports = await hub.go()
    return reports[-1]["count"] / SECONDS, hub.line_limit() / 2


def sdo_peer() -> float | None:
    """Round trips a second of canopen's LocalNode over udp_multicast; None where no namespace can be made."""
    setup = 'ip link set lo up multicast on && ip route add 239.0.0.0/8 dev lo && exec "$@"'
    peer = [sys.executable, str(Path(__file__).with_name("sdo_peer.py")), str(EDS), str(SECONDS)]
    try:
        done = subprocess.run(
            ["unshare", "-rn", "sh", "-c", setup, "sh", *peer], check=True, capture_output=True, text=True, timeout=60
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return float(done.stdout.split()[-1])


def run() -> Report:
    report = Report(
        "CAN hub",
        f"This table shows the throughput of a hub at 1 Mbit/s, or without pacing, over {SECONDS:g} s each. Every node"
        " is a process of its own.",
        COMPARED,
    )
    progress("CAN hub: a full bus")
    frames_per_s, limit_per_s, cpu = uvloop.run(full_bus())
    report.add("frames of 8 bytes, 8 busy nodes", f"{frames_per_s:,.0f}/s", f"the line's limit {limit_per_s:,.0f}/s",
               f"{frames_per_s / limit_per_s:.3f}")  # fmt: skip
    for who, percent in cpu.items():
        report.add(f"CPU of the {who} during this", f"{percent:.1f} %", "one core", "")
    progress("CAN hub: SDO at 1 Mbit/s")
    per_s, limit_per_s = uvloop.run(sdo(BITRATE))
    report.add("SDO round trips, paced", f"{per_s:,.0f}/s", f"the line's limit {limit_per_s:,.0f}/s",
               f"{per_s / limit_per_s:.3f}")  # fmt: skip
    progress("CAN hub: SDO unpaced")
    unpaced = {
        "unpaced": uvloop.run(sdo(None))[0],
        "unpaced, node in the process of the hub": uvloop.run(sdo(None, in_hub=True))[0],
    }
    progress("CAN hub: SDO of canopen's LocalNode over udp_multicast")
    peer_per_s = sdo_peer()
    if peer_per_s is None:
        report.notes.append("canopen's LocalNode was not measured: `unshare -rn` is not possible here")
    for how, per_s in unpaced.items():
        report.add(f"SDO round trips, {how}", f"{per_s:,.0f}/s",
                   "-" if peer_per_s is None else f"canopen LocalNode over udp_multicast {peer_per_s:,.0f}/s",
                   "-" if peer_per_s is None else f"{per_s / peer_per_s:.2f}")  # fmt: skip
    return report


if __name__ == "__main__":
    if len(sys.argv) > 1:
        uvloop.run(be_member(*sys.argv[1:]))
    else:
        print(run().markdown())
