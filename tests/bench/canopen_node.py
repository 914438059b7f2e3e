"""The CANopen node: block transfers of 100 kB, the jitter of its answers to SYNC, and a full virtual bus of 32 nodes.

CANopenNode's figures are those it publishes for 100 kB on vcan, where no line limits it; they are noted, not measured.
(Not `canopen.py`: this folder is looked through before python canopen's package.)
"""

import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import can_hub
import uvloop
from canopen_peers import (
    DATA,
    NODE_ID,
    REQUEST_ID,
    RESPONSE_ID,
    SYNC_ID,
    SYNC_PERIOD_NS,
    TPDOS,
    BlockClient,
    SyncProducer,
    eds_with_tpdos,
)
from report import COMPARED, Report, percentile, progress

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import classical_bits

HERE = Path(__file__).parent
PEER_DOWNLOAD_MS, PEER_UPLOAD_MS = 70, 145
"""CANopenNode, 100 kB on vcan, as published."""
NODES = 32
SECONDS = 5.0  # a line of 1 Mbit/s takes 3.6 s for both directions
WALL_S = 2.0


class Heard(NamedTuple):
    time_ns: int
    identifier: int
    first: int
    """The first byte; -1 without one."""


class Hub(can_hub.Hub):
    """Keeps what went over the bus with its instants."""

    script = __file__

    def __init__(self, bitrate: int | None) -> None:
        super().__init__(bitrate)
        self.heard: list[Heard] = []

    def _on_delivery(self, delivery: Delivery[CanFrame]) -> None:
        frame = delivery.message
        self.frames.append(frame)
        self.heard.append(Heard(delivery.time_ns, frame.identifier, frame.data[0] if frame.data else -1))


class Blocks(can_hub.Member):
    def __init__(self, link: Link[CanFrame], clock: RealClock) -> None:
        self.count = 0
        self._client = BlockClient(link, clock, self._on_done)

    def begin(self) -> None:
        self._client.begin()

    def _on_done(self, downloaded_ns: int, uploaded_ns: int) -> None:
        self.count += 1


class Syncs(can_hub.Member):
    def __init__(self, link: Link[CanFrame], clock: RealClock) -> None:
        self.count = 0
        self._producer = SyncProducer(link, clock)

    def begin(self) -> None:
        self._producer.begin()


can_hub.ROLES["blocks"] = lambda link, clock: Blocks(link, clock)
can_hub.ROLES["syncs"] = lambda link, clock: Syncs(link, clock)


async def blocks(bitrate: int | None) -> tuple[float, float, float]:
    """Milliseconds of download and upload by the bus's instants, and what the line alone takes for each."""
    hub = Hub(bitrate)
    await hub.start(("server", "io", can_hub.EDS), ("blocks", "master"))
    reports = await hub.go()
    if reports[1]["count"] != 1:
        raise RuntimeError(f"not done within {SECONDS} s")
    return _durations(hub)


def _durations(hub: Hub) -> tuple[float, float, float]:
    """Duration from the initiating request to the last answer of a download, or the last request of an upload."""
    marks = {(frame.identifier, frame.first): frame.time_ns for frame in hub.heard}
    first_ns, uploading_ns = marks[REQUEST_ID, 0xC6], marks[REQUEST_ID, 0xA4]
    downloaded_ns, uploaded_ns = marks[RESPONSE_ID, 0xA1], marks[REQUEST_ID, 0xA1]
    line_ms = sum(map(classical_bits, hub.frames)) / 2 / can_hub.BITRATE * 1000
    return (downloaded_ns - first_ns) / MS, (uploaded_ns - uploading_ns) / MS, line_ms


async def jitter() -> tuple[list[float], list[float]]:
    """Microseconds from each SYNC to the first answer, and to the last of TPDOS."""
    hub = Hub(can_hub.BITRATE)
    eds = hub.run / "tpdos.eds"
    eds.write_text(eds_with_tpdos())
    await hub.start(("server", "io", eds), ("syncs", "master"))
    await hub.go()
    firsts: list[float] = []
    lasts: list[float] = []
    syncs = [number for number, frame in enumerate(hub.heard) if frame.identifier == SYNC_ID]
    for number in syncs[10:-1]:
        answers = hub.heard[number + 1 : number + 1 + TPDOS]
        if all(frame.identifier >= 0x180 for frame in answers):
            firsts.append((answers[0].time_ns - hub.heard[number].time_ns) / 1000)
            lasts.append((answers[-1].time_ns - hub.heard[number].time_ns) / 1000)
    return firsts, lasts


def virtual_blocks() -> tuple[float, float, float]:
    """Milliseconds of download and upload on the virtual line, and of wall time for both."""
    done: list[int] = []
    with Rig(from_dict(_node_rig(), HERE)) as rig:
        master = rig.attach("master")
        client = BlockClient(master.link("can0"), master.clock, lambda *took: done.extend(took))
        rig.run_until(MS)
        start_s = time.perf_counter()
        client.begin()
        while not done:
            rig.run_until(rig.now_ns + 100 * MS)
        wall_s = time.perf_counter() - start_s
    return done[0] / MS, done[1] / MS, wall_s * 1000


def _node_rig() -> dict[str, Any]:
    node = {"kind": "canopen.node", "node_id": NODE_ID, "eds": str(can_hub.EDS), "links": {"can": "can0"}}
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": can_hub.BITRATE}},
        "devices": {"io": node},
    }


def full_virtual_bus() -> tuple[float, float]:
    """Frames a second of wall time on a bus that NODES keep full, and virtual seconds a second."""
    relay = {"kind": "bench_kinds:Relay", "of": NODES, "links": {"can": "can0"}}
    content = {
        "time": "virtual",
        "processes": "one",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": can_hub.BITRATE}},
        "devices": {f"relay{number}": {**relay, "number": number} for number in range(NODES)},
    }
    count = 0

    def on_delivery(_bus: Bus[Any], _delivery: Delivery[Any]) -> None:
        nonlocal count
        count += 1

    with Rig(from_dict(content, HERE), on_delivery) as rig:
        rig.run_until(10 * MS)
        count, start_s, start_ns = 0, time.perf_counter(), rig.now_ns
        while (wall_s := time.perf_counter() - start_s) < WALL_S:
            rig.run_until(rig.now_ns + 10 * MS)
        return count / wall_s, (rig.now_ns - start_ns) / S / wall_s


def run() -> Report:
    report = Report(
        "CANopen node",
        f"This table shows block transfers of {len(DATA) // 1000} kB with CRC, and the answers to a SYNC every"
        f" {SYNC_PERIOD_NS / MS:g} ms. Hub, node and master are processes of their own.",
        COMPARED,
    )
    for name, bitrate in (("1 Mbit/s", can_hub.BITRATE), ("unpaced", None)):
        progress(f"CANopen: blocks over the hub, {name}")
        downloaded_ms, uploaded_ms, line_ms = uvloop.run(blocks(bitrate))
        for what, took_ms, peer_ms in (
            ("download", downloaded_ms, PEER_DOWNLOAD_MS),
            ("upload", uploaded_ms, PEER_UPLOAD_MS),
        ):
            against = (
                f"the line's limit {line_ms:,.0f} ms" if bitrate else f"CANopenNode on vcan, published: {peer_ms} ms"
            )
            ratio = took_ms / (line_ms if bitrate else peer_ms)
            report.add(f"block {what} over the hub, {name}", f"{took_ms:,.0f} ms", against, f"{ratio:.3f}")
    progress("CANopen: blocks in virtual time")
    downloaded_ms, uploaded_ms, wall_ms = virtual_blocks()
    both_ms = downloaded_ms + uploaded_ms
    report.add("block download and upload in virtual time, 1 Mbit/s", f"{both_ms:,.0f} virtual ms in {wall_ms:,.0f} ms",
               "real time", f"{both_ms / wall_ms:.2f}")  # fmt: skip
    progress("CANopen: jitter of the answers to SYNC")
    firsts, lasts = uvloop.run(jitter())
    period_us = SYNC_PERIOD_NS / 1000
    for what, delays in (("first", firsts), (f"last of {TPDOS}", lasts)):
        p50, p99 = percentile(delays, 50), percentile(delays, 99)
        report.add(f"SYNC to the {what} TPDO, {len(delays)} times, p50/p99", f"{p50:,.0f}/{p99:,.0f} us",
                   f"the period {period_us:,.0f} us", f"{p99 / period_us:.3f}")  # fmt: skip
    progress("CANopen: a full virtual bus")
    frames_per_s, speed = full_virtual_bus()
    report.add(
        f"virtual bus of {NODES} nodes at 100 % load", f"{frames_per_s:,.0f} frames/s", "real time", f"{speed:.2f}"
    )
    return report


if __name__ == "__main__":
    if len(sys.argv) > 1:
        can_hub.SECONDS = SECONDS
        uvloop.run(can_hub.be_member(*sys.argv[1:]))
    else:
        print(run().markdown())
