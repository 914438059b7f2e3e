"""Law: edges, segments, the position and a counter at the wire agree after any sequence of commands."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

import pytest
from hmiscu_device_bench import PTO, DeviceBench
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal
from fieldrig_devices.pulses.pulse_input import PulseInput

LONG_MS = 3_000
"""After this time every move that ends by itself has ended, and the counters are compared."""

Edge = tuple[int, bool]
"""Instant in ns, and level."""


class Wave(NamedTuple):
    frequency: int
    duty: int
    after_ms: int
    is_on: bool = True
    is_sync: bool = False


class Deed(NamedTuple):
    what: str
    frequency: int
    after_ms: int


DEEDS = st.lists(
    st.builds(
        Deed,
        st.sampled_from(
            [
                "velocity",
                "relative",
                "stop",
                "start frequency",
                "stop frequency",
                "release",
                "not ready",
                "ready",
                "reset",
            ]
        ),
        st.sampled_from([1, 20, 50, 100, 333, 2_000]),
        st.sampled_from([0, 1, 5, 10, 20, 37, 200]),
    ),
    max_size=8,
)
WAVES = st.lists(
    st.builds(
        Wave,
        st.sampled_from([10, 100, 500, 1_000, 3_330]),
        st.sampled_from([0, 1, 20, 50, 99, 100]),
        st.integers(0, 130),
        st.booleans(),
        st.booleans(),
    ),
    max_size=8,
)


D = TypeVar("D", Deed, Wave)


def carry_out(bench: DeviceBench, deed: Deed) -> None:
    match deed.what:
        case "velocity" | "relative":
            block = {"velocity": "MoveVelocity", "relative": "MoveRelative"}[deed.what]
            pins = {"Velocity": deed.frequency, "Acceleration": 100, "Deceleration": 20}
            for pin, value in pins.items():
                bench.set(f"{block}.{pin}", value)
            if deed.what == "relative":
                bench.set("MoveRelative.Distance", deed.frequency // 2 + 1)
            bench.set(f"{block}.Execute", True)
        case "stop":
            bench.set("Stop.Deceleration", 50)
            bench.set("Stop.Execute", True)
        case "start frequency" | "stop frequency":
            bench.set("SetParam.Param", int(deed.what == "stop frequency"))
            bench.set("SetParam.Param_Value", deed.frequency)
            bench.set("SetParam.Execute", True)
        case "release":
            for block in ("MoveVelocity", "MoveRelative", "Stop", "SetParam"):
                bench.set(f"{block}.Execute", False)
        case "reset":
            bench.set("PTO00.ResetError", True)
        case _:
            bench.wire("drive.ready", deed.what == "ready")


def modulate(bench: DeviceBench, wave: Wave) -> None:
    bench.set("PWM00.F_Enable", wave.is_on)
    bench.set("PWM00.F_Sync", wave.is_sync)
    bench.set("PWM00.Frequency", wave.frequency)
    bench.set("PWM00.Duty", wave.duty)


def played(
    mode: str, channel: dict[str, object], deeds: Sequence[D], apply: Callable[[DeviceBench, D], None]
) -> tuple[DeviceBench, list[Edge], list[PulseTrain | Pwm], PulseInput]:
    """Return the bench, what the wire had as edges and as segments, and a counter that was at the wire."""
    bench = DeviceBench(channel_0=channel, fast_signals=mode)
    edges: list[Edge] = []
    segments: list[PulseTrain | Pwm] = []
    counter = PulseInput(0)
    seen = 0

    def take() -> None:
        nonlocal seen
        for signal in bench.wires.sent[seen:]:
            if signal.name == "direction":
                counter.is_reverse = not signal.value
            elif signal.name == "pulse":
                note(signal)
                counter.receive(signal, bench.clock.now_ns())
        seen = len(bench.wires.sent)

    def note(signal: Signal) -> None:
        if isinstance(signal, PulseTrain | Pwm):
            segments.append(signal)
        else:
            edges.append((bench.clock.now_ns(), bool(signal.value)))

    def run(time_ms: int) -> None:
        until_ns = bench.clock.now_ns() + time_ms * MS
        while (next_ns := bench.clock.next_ns()) is not None and next_ns <= until_ns:
            bench.clock.advance_to(next_ns)
            take()
        bench.clock.advance_to(until_ns)

    take()
    for deed in deeds:
        apply(bench, deed)
        run(0)
        run(deed.after_ms)
    run(LONG_MS)
    return bench, edges, segments, counter


def edges_of(segments: Sequence[PulseTrain | Pwm], end_ns: int) -> list[Edge]:
    """The changes of the level that segments describe."""
    levels: list[Edge] = []
    for number, segment in enumerate(segments):
        until_ns = segments[number + 1].start_ns if number + 1 < len(segments) else end_ns + 1
        if segment.start_ns < until_ns:
            levels.append((segment.start_ns, segment.level_at(segment.start_ns)))
            levels += segment.edges(segment.start_ns + 1, until_ns)
    return changes(levels)


def changes(levels: Sequence[Edge]) -> list[Edge]:
    found: list[Edge] = []
    for instant, level in levels:
        if level != (found[-1][1] if found else False):
            found.append((instant, level))
    return found


def check_no_pulse_without_width(edges: Sequence[Edge]) -> None:
    instants = [instant for instant, _ in edges[1:]]  # the first one is the level at power-on
    assert len(instants) == len(set(instants))


@pytest.mark.long
@pytest.mark.manual("SCU-008")
@pytest.mark.parametrize("ramps", ["periods", "smooth"])
@settings(max_examples=60)
@given(DEEDS)
@example([Deed("velocity", 50, 200), Deed("stop", 0, 37)])
def test_pulses_are_the_same_by_edges_and_by_segments(ramps: str, deeds: list[Deed]) -> None:
    channel = PTO | {"ramps": ramps, "aux": "drive_ready"}
    start = [Deed("ready", 0, 5), Deed("reset", 0, 10)]
    whole, _, segments, by_segments = played("segments", channel, start + deeds, carry_out)
    edgewise, edges, _, by_edges = played("edges", channel, start + deeds, carry_out)
    end_ns = whole.clock.now_ns()
    check_no_pulse_without_width(edges)
    assert changes(edges) == edges_of(segments, end_ns)
    assert by_edges.received_at(end_ns) == by_segments.received_at(end_ns)
    assert whole.get("PTO00.Position") == edgewise.get("PTO00.Position") == by_edges.position_at(end_ns)


@pytest.mark.long
@settings(max_examples=60)
@given(WAVES)
@example([Wave(500, 20, 100), Wave(500, 50, 100)])
@example([Wave(100, 50, 122), Wave(100, 50, 10, is_sync=True)])  # a cycle that begins while the output is high
@example([Wave(500, 20, 105), Wave(500, 20, 10, is_on=False, is_sync=True)])  # off and synchronised in one call
@example([Wave(500, 20, 85), Wave(500, 50, 10), Wave(500, 50, 10, is_on=False)])  # off when the change takes effect
@example([Wave(500, 20, 50), Wave(500, 100, 10)])
def test_pwm_is_the_same_by_edges_and_by_segments(waves: list[Wave]) -> None:
    channel: dict[str, object] = {"mode": "pwm"}
    whole, _, segments, by_segments = played("segments", channel, waves, modulate)
    _, edges, _, by_edges = played("edges", channel, waves, modulate)
    end_ns = whole.clock.now_ns()
    check_no_pulse_without_width(edges)
    assert changes(edges) == edges_of(segments, end_ns)
    assert by_edges.received_at(end_ns) == by_segments.received_at(end_ns)


@pytest.mark.manual("SCU-008")
def test_the_first_pulse_of_a_steep_ramp_is_high_for_half_of_its_period() -> None:
    deeds = [Deed("ready", 0, 5), Deed("reset", 0, 10), Deed("relative", 2_000, 0)]
    _, edges, _, _ = played("edges", PTO | {"aux": "drive_ready"}, deeds, carry_out)
    (rise_ns, _), (fall_ns, _), (next_ns, _) = [edge for edge in edges if edge[0]][:3]
    assert abs((fall_ns - rise_ns) - (next_ns - fall_ns)) <= 1
