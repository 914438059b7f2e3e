"""Faults of the hardware: short circuits, temperatures, wires, frames, FIFOs and the battery."""

import pytest
from smart_io_bench import SmartIoBench

from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import InputItem, OutputItem, SetOutput, Severity, Trouble


@pytest.fixture
def bench() -> SmartIoBench:
    bench = SmartIoBench()
    bench.configure(OutputItem(1, 105, 1, True), OutputItem(2, 212, 1, True), InputItem(3, 103, 1, True, 1, 1))
    return bench


@pytest.mark.manual("PAMS-052")
@pytest.mark.manual("PAMS-105")
@pytest.mark.parametrize(("item", "address", "detail"), [(1, 105, 0x1_0002), (2, 212, 0x2_0003)])
def test_a_short_circuit_is_reported_by_group_while_the_output_is_on(
    bench: SmartIoBench, item: int, address: int, detail: int
) -> None:
    bench.device.add_fault({"what": "short_circuit", "address": address})
    assert bench.port.take() == []
    bench.order(SetOutput(item, 1))
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00E, (detail, 5))]
    assert bench.get(f"out{address}") is False
    assert bench.get("error_word") == 0, "it has no bit"
    bench.device.clear_fault(1)
    assert bench.port.take() == [Trouble(Severity.ENDED, 0x00E, (detail, 5))]
    assert bench.get(f"out{address}") is True


@pytest.mark.manual("PAMS-051")
@pytest.mark.manual("PAMS-105")
@pytest.mark.parametrize(
    ("fault", "code", "details", "word"),
    [
        ({"what": "overtemperature", "module": 1}, 0x00E, (0x1_0000, 6), 0x10),
        ({"what": "overtemperature", "module": 8}, 0x00E, (0x8_0000, 6), 0x800),
        ({"what": "overtemperature", "module": 9}, 0x00E, (0x9_0000, 6), 0),
        ({"what": "overtemperature"}, 0x00C, (0x08, 0), 0x1000),
        ({"what": "damaged_frames"}, 0x00C, (0x03, 0), 0x4),
        ({"what": "damaged_frames", "of": "type"}, 0x00C, (0x04, 0), 0x8),
        ({"what": "full_fifo", "number": 2}, 0x00C, (0x02, 2), 0x2),
    ],
)
def test_faults_of_the_hardware_begin_and_end(
    fault: dict[str, object], code: int, details: tuple[int, int], word: int
) -> None:
    bench = SmartIoBench(modules={number: {} for number in range(1, 10)})
    bench.configure()
    bench.device.add_fault(fault)
    assert bench.port.take() == [Trouble(Severity.WARNING, code, details, word)]
    assert bench.get("error_word") == word
    bench.device.clear_fault(1)
    assert bench.port.take() == [Trouble(Severity.ENDED, code, details)]


@pytest.mark.manual("PAMS-112")
@pytest.mark.parametrize("number", range(1, 9))
def test_a_full_fifo_is_on_the_display(bench: SmartIoBench, number: int) -> None:
    bench.device.add_fault({"what": "full_fifo", "number": number, "duration_ms": 50})
    assert bench.get("display") == f"E {number}"
    bench.run(50)
    assert bench.get("display") == " "


def test_a_crc_error_of_the_ring_is_reported_too(bench: SmartIoBench) -> None:
    bench.program.ring(RingFault.CRC)
    assert bench.port.take() == [Trouble(Severity.WARNING, 0x00C, (0x03, 0), 0x4)]
    bench.program.ring(RingFault.NONE)
    assert bench.port.take() == [Trouble(Severity.ENDED, 0x00C, (0x03, 0))]


def test_a_fault_that_is_older_than_the_pam_is_reported_when_the_node_begins_to_run() -> None:
    bench = SmartIoBench()
    bench.device.add_fault({"what": "overtemperature"})
    bench.program.attach(bench.port)
    bench.program.forget()
    bench.device.add_fault({"what": "damaged_frames"})
    assert bench.port.take() == []
    bench.program.run()
    assert bench.port.take() == [
        Trouble(Severity.WARNING, 0x00C, (0x08, 0), 0x1004),
        Trouble(Severity.WARNING, 0x00C, (0x03, 0), 0x1004),
    ]


def test_an_input_with_a_broken_wire_is_low(bench: SmartIoBench) -> None:
    bench.wire("button", True)
    bench.run(5)
    bench.device.add_fault({"what": "broken_wire", "address": 103})
    bench.run(5)
    bench.device.clear_fault(1)
    bench.run(5)
    assert bench.inputs() == [(3, 1), (3, 0), (3, 1)]


@pytest.mark.manual("PAMS-112")
def test_a_low_battery_loses_the_configuration(bench: SmartIoBench) -> None:
    bench.order(SetOutput(1, 1))
    bench.device.add_fault({"what": "low_battery"})
    assert (bench.get("display"), bench.get("out105")) == ("F 4", False)
    bench.set("out105", True)
    bench.configure(OutputItem(1, 105, 1, True))
    assert (bench.get("display"), bench.get("out105")) == (" ", False)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({"what": "short_circuit", "address": 301}, "there is no out301"),
        ({"what": "broken_wire", "address": 113}, "there is no in113"),
        ({"what": "full_fifo", "number": 9}, "number"),
    ],
)
def test_a_fault_of_what_is_not_there_is_refused(bench: SmartIoBench, fault: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        bench.device.add_fault(fault)
