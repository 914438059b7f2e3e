"""Python canopen's master against the node, over a wire of function calls."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.sdo.exceptions import SdoAbortedError
from canopen.variable import Variable
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench

from fieldrig_bus.can.frame import CanFrame


class Wire(canopen.Network):
    """A network that hands frames to the bench and gives back at once what comes out."""

    def __init__(self, bench: CanopenBench) -> None:
        super().__init__()
        self.bench = bench
        self.heard: list[int] = []

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self.bench.can.deliver(CanFrame(can_id, bytes(data), is_remote=remote))
        self.run(0)

    def run(self, ms: float) -> None:
        self.bench.clock.advance_to(self.bench.clock.now_ns() + round(ms * 1e6))
        for frame in self.bench.can.take():
            self.heard.append(frame.identifier)
            self.notify(frame.identifier, bytearray(frame.data), self.bench.clock.now_ns() / 1e9)


Connect = Callable[[Path], tuple[Wire, Any]]


def connect(path: Path = IO32, **settings: Any) -> tuple[Wire, Any]:
    wire = Wire(CanopenBench(path, **settings))
    return wire, wire.add_node(5, str(path))


@pytest.mark.parametrize("path", [IO32, LEVEL_SENSOR], ids=lambda path: path.name)
def test_every_object_is_read_with_its_default(path: Path) -> None:
    wire, node = connect(path)
    count = 0
    for ours in wire.bench.node.dictionary:
        if ours.index == 0x1003 and ours.subindex > 0:
            continue
        their = node.object_dictionary.get_variable(ours.index, ours.subindex)
        entry = node.sdo[ours.index]
        variable = entry if isinstance(entry, Variable) else entry[ours.subindex]
        assert their.default is None or variable.raw == their.default, ours.key
        count += 1
    assert count > 50


@pytest.mark.parametrize("path", [IO32, LEVEL_SENSOR], ids=lambda path: path.name)
@pytest.mark.parametrize("is_segmented", [False, True])
def test_every_object_is_written_back_or_refused_as_read_only(path: Path, is_segmented: bool) -> None:
    wire, node = connect(path)
    for ours in wire.bench.node.dictionary:
        if ours.index == 0x1003:
            continue
        data = node.sdo.upload(ours.index, ours.subindex)
        if ours.access.is_writable:
            is_locked = ours.index & 0xFF00 in (0x1600, 0x1A00) and ours.subindex > 0
            if is_locked:
                node.sdo.download(ours.index & ~0x200, 1, (0x8000_0000).to_bytes(4, "little"))
                node.sdo.download(ours.index, 0, b"\x00")
            node.sdo.download(ours.index, ours.subindex, data, force_segment=is_segmented)
            assert node.sdo.upload(ours.index, ours.subindex) == data
        else:
            with pytest.raises(SdoAbortedError, match="0x06010002"):
                node.sdo.download(ours.index, ours.subindex, data, force_segment=is_segmented)


def test_long_text_goes_both_ways_in_segments(tmp_path: Path) -> None:
    path = tmp_path / "text.eds"
    path.write_text(
        "[DeviceInfo]\n[1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\n"
        "[2000]\nParameterName=Text\nDataType=9\nAccessType=rw\n"
    )
    _, node = connect(path)
    for text in ["", "a", "1234567", "12345678", "x" * 1000]:
        node.sdo["Text"].raw = text
        assert node.sdo["Text"].raw == text


def test_heartbeat_and_states() -> None:
    wire, node = connect(objects={"1017:00": 100})
    wire.run(100)
    assert node.nmt.state == "PRE-OPERATIONAL"
    node.nmt.state = "OPERATIONAL"
    wire.run(100)
    assert (node.nmt.state, wire.heard.count(0x705)) == ("OPERATIONAL", 3)
    node.nmt.send_command(129)
    assert wire.heard[-1] == 0x705
    wire.run(100)
    assert node.nmt.state == "PRE-OPERATIONAL"


def test_outputs_by_rpdo_and_inputs_by_tpdo() -> None:
    wire, node = connect()
    node.tpdo.read()
    node.rpdo.read()
    node.nmt.state = "OPERATIONAL"
    wire.run(0)
    node.rpdo[1]["Write output 8-bit.Write outputs byte 2"].raw = 0xA5
    node.rpdo[1].transmit()
    assert wire.bench.point("6200:02") == 0xA5
    wire.bench.set("6000:03", 0x5A)
    wire.run(0)
    assert node.tpdo[1]["Read input 8-bit.Read inputs byte 3"].raw == 0x5A


def test_pdos_are_mapped_anew_and_run_by_sync() -> None:
    wire, node = connect()
    node.tpdo.read()
    node.tpdo[1].clear()
    node.tpdo[1].add_variable("Read analogue input 16-bit", "Analogue input 1")
    node.tpdo[1].add_variable("Read input 8-bit", "Read inputs byte 1")
    node.tpdo[1].trans_type = 1
    node.tpdo[1].save()
    node.nmt.state = "OPERATIONAL"
    wire.bench.set("6401:01", -1234)
    wire.bench.set("6000:01", 0x21)
    assert 0x185 not in wire.heard
    wire.sync.transmit()
    assert wire.heard[-1] == 0x185
    assert bytes(node.tpdo[1].data) == struct.pack("<hB", -1234, 0x21)


def test_emergencies_arrive() -> None:
    wire, node = connect()
    wire.bench.node.emcy.raise_error(0x4210, 0x08, b"\x01\x02\x03\x04\x05")
    wire.run(0)
    (error,) = node.emcy.active
    assert (error.code, error.register, bytes(error.data)) == (0x4210, 0x09, b"\x01\x02\x03\x04\x05")
    wire.bench.node.emcy.clear_error(0x4210)
    wire.run(0)
    assert node.emcy.active == []
