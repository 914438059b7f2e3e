"""Pulses on wires: the cost of a move, of an hour of two fast outputs, and of each edge where edges are wanted."""

import io
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from report import COMPARED, Report, progress

from fieldrig.clock import S
from fieldrig.config.rig_file import from_dict
from fieldrig.traces.trace import TraceEntry
from fieldrig.virtual.rig import Rig
from fieldrig_bus.signals.codec import decode, encode
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.traces import vcd

MOST_PULSES = 4_294_967_295
FAST_HZ = 50_000
LINKS = {"links": {"wires": "wires"}}


def run() -> Report:
    report = Report(
        "Pulses",
        "A pulse train is one message for a segment; with edges, it is one for each edge.  A move is sent, encoded, "
        "decoded, and asked for its end, its count and its last edge.",
        COMPARED,
    )
    progress("pulses: moves")
    long_us, short_us = (fastest_us(partial(move, count)) for count in (MOST_PULSES, 10))
    report.add(f"a move of {MOST_PULSES:,} pulses", f"{long_us:.0f} us", "1 ms", long_us / 1000)
    report.add(f"a move of {MOST_PULSES:,} pulses", f"{long_us:.0f} us", "a move of 10", long_us / short_us)
    progress("pulses: an hour")
    wall_s = seconds(rig("segments", 2), 3600)
    report.add(
        f"2 outputs at {FAST_HZ:,} Hz with counters, for an hour", f"{wall_s * 1000:.1f} ms", "real time", wall_s / 3600
    )
    progress("pulses: edges")
    edges = 2 * FAST_HZ / seconds(rig("edges", 1), 1)
    report.add(
        "edge by edge to a counter", f"{edges:,.0f} edges/s", f"the edges of {FAST_HZ:,} Hz", edges / 2 / FAST_HZ
    )
    progress("pulses: waveform")
    train = PulseTrain("p", 0, frequency=FAST_HZ, count=100_000)
    start_s = time.perf_counter()
    vcd.write([TraceEntry(0, "wires", "wires", "x", encode(train)), end_of(train)], io.BytesIO(), 0)
    edges = 200_000 / (time.perf_counter() - start_s)
    report.add("export of a waveform", f"{edges:,.0f} edges/s", f"the edges of {FAST_HZ:,} Hz", edges / 2 / FAST_HZ)
    return report


def move(count: int) -> None:
    """Everything that a sender and a receiver do with one move."""
    train = decode(encode(PulseTrain("p", 0).then(S, FAST_HZ, count=count)))
    assert isinstance(train, PulseTrain)
    assert train.end_ns is not None
    assert train.pulses_at(train.end_ns) == count
    assert train.rise_ns(count) is not None


def fastest_us(action: Callable[[], None]) -> float:
    """The time of the fastest of many calls, as the others share the host."""
    found = []
    for _ in range(300):
        start_ns = time.perf_counter_ns()
        action()
        found.append(time.perf_counter_ns() - start_ns)
    return min(found) / 1000


def end_of(train: PulseTrain) -> TraceEntry:
    assert train.end_ns is not None
    return TraceEntry(train.end_ns, "wires", "wires", "x", encode(train.then(train.end_ns)))


def rig(output: str, outputs: int) -> dict[str, Any]:
    devices: dict[str, Any] = {}
    for number in range(outputs):
        source = {"kind": "pulse.generator", "frequency": FAST_HZ, "output": output, "run": True}
        devices[f"source{number}"] = source | LINKS
        devices[f"counter{number}"] = {"kind": "pulse.counter", "a_wire": f"source{number}.pulse"} | LINKS
    return {"time": "virtual", "buses": {"wires": {"kind": "wires.virtual"}}, "devices": devices}


def seconds(data: dict[str, Any], virtual_s: int) -> float:
    """The wall time that a rig takes for this virtual time."""
    with Rig(from_dict(data)) as running:
        start_s = time.perf_counter()
        running.run_until(virtual_s * S)
        assert running.get("counter0", "value") in (virtual_s * FAST_HZ, virtual_s * FAST_HZ + 1)
        return time.perf_counter() - start_s


if __name__ == "__main__":
    print(run().markdown())
