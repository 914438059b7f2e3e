"""CiA 401: polarity, filter, error values and interrupt conditions of the I/O module."""

from typing import Any

import pytest
from canopen_bench import CanopenBench

from fieldrig_bus.wires import Signal

START, STOP = "000#01 05", "000#02 05"


def wired(**objects: Any) -> CanopenBench:
    """The I/O module with output byte 1 on wire `out`, input byte 1 on `in`, and analog channels on `ao` and `ai`."""
    signals = {"6200:01": "out", "6000:01": "in", "6411:01": "ao", "6401:01": "ai"}
    bench = CanopenBench(signals=signals, objects={key.replace("_", ":")[1:]: value for key, value in objects.items()})
    bench.send(START)
    bench.wires.take()
    return bench


def feel(bench: CanopenBench, name: str, *values: int) -> list[str]:
    for value in values:
        bench.wires.deliver(Signal(name, value))
    return bench.after(0)


def signals(bench: CanopenBench) -> list[tuple[str, object]]:
    return [(signal.name, signal.value) for signal in bench.wires.take()]


def test_polarity_turns_an_output_around() -> None:
    bench = wired(o6202_01=0x0F)
    bench.send("205#33 00 00 00")
    assert signals(bench) == [("out", 0x3C)]
    bench.write("2f 02 62 01 00 00 00 00")
    assert signals(bench) == [("out", 0x33)]


def test_filter_mask_holds_an_output() -> None:
    bench = wired(o6208_01=0x0F)
    bench.send("205#ff 00 00 00")
    assert signals(bench) == [("out", 0x0F)]


def test_polarity_turns_an_input_around() -> None:
    bench = wired(o6002_01=0x0F)
    assert feel(bench, "in", 0x33) == ["185#3c 00 00 00"]
    bench.write("2f 02 60 01 00 00 00 00")
    assert bench.point("6000:01") == 0x33


@pytest.mark.parametrize("end", [STOP, "000#02 00"])
def test_stopped_module_goes_to_its_error_values(end: str) -> None:
    bench = wired(o6206_01=0x0F, o6207_01=0x55, o6443_01=1, o6444_01=-7)
    bench.send("205#f0 00 00 00", "305#64 00 00 00 00 00 00 00")
    assert signals(bench) == [("out", 0xF0), ("ao", 100)]
    bench.send(end)
    assert signals(bench) == [("out", 0xF5), ("ao", -7)]
    bench.send(START)
    assert signals(bench) == [("out", 0xF0), ("ao", 100)]


def test_without_error_mode_outputs_stay() -> None:
    bench = wired(o6206_01=0x00, o6443_01=0)
    bench.send("205#f0 00 00 00", "305#64 00 00 00 00 00 00 00")
    signals(bench)
    bench.send(STOP)
    assert signals(bench) == []


def test_lost_heartbeat_puts_outputs_to_their_error_values_until_operational() -> None:
    bench = wired(o1016_01=0x0009_0064)
    bench.send("205#f0 00 00 00", "709#05")
    signals(bench)
    bench.after(100)
    assert signals(bench) == [("out", 0)]
    bench.send("709#05")
    assert signals(bench) == []
    bench.send(START)
    assert signals(bench) == [("out", 0xF0)]


def test_reset_node_clears_outputs() -> None:
    bench = wired()
    bench.send("205#f0 00 00 00")
    signals(bench)
    bench.send("000#81 05")
    assert signals(bench) == [("out", 0)]


def test_digital_interrupt_masks_choose_the_changes() -> None:
    bench = wired(o6006_01=0x00, o6007_01=0x01, o6008_01=0x02)
    assert feel(bench, "in", 0x01) == ["185#01 00 00 00"]
    assert feel(bench, "in", 0x03) == []
    assert feel(bench, "in", 0x02) == []
    assert feel(bench, "in", 0x00) == ["185#00 00 00 00"]


def test_global_interrupt_enable_of_digital_inputs() -> None:
    assert feel(wired(o6005_00=False), "in", 1) == []


def test_analog_inputs_are_silent_until_enabled() -> None:
    bench = wired()
    assert feel(bench, "ai", 100) == []
    bench.write("2f 23 64 00 01 00 00 00")
    assert feel(bench, "ai", 101) == ["285#65 00 00 00 00 00 00 00"]


# Trigger selection, upper and lower limit, delta, negative and positive delta; inputs, and those that are events.
ANALOG = [
    ((0x07, 0, 0, 0, 0, 0), [1, -1, 5], [1, -1, 5]),
    ((0x07, 0, 0, 10, 0, 0), [9, 10, 19, 20, 11, 10], [10, 20, 10]),
    ((0x01, 100, 0, 0, 0, 0), [99, 100, 101, 50], [100, 101]),
    ((0x02, 0, 50, 0, 0, 0), [50, 49, 48, 60], [49, 48]),
    ((0x08, 0, 0, 0, 10, 0), [20, 11, -10, -5], [-10]),
    ((0x10, 0, 0, 0, 0, 10), [9, 10, 15, 20, 0], [10, 20]),
    ((0x03, 100, -100, 0, 0, 0), [50, 120, -120], [120, -120]),
]


@pytest.mark.parametrize(("settings", "inputs", "events"), ANALOG)
def test_analog_interrupt_conditions(settings: tuple[int, ...], inputs: list[int], events: list[int]) -> None:
    keys = ("o6421_01", "o6424_01", "o6425_01", "o6426_01", "o6427_01", "o6428_01")
    bench = wired(o6423_00=True, **dict(zip(keys, settings, strict=True)))
    sent = [value for value in inputs if feel(bench, "ai", value)]
    assert sent == events
