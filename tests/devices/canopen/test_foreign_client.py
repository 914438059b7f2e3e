"""The master of python-canopen against the node, connected by function calls."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.sdo.exceptions import SdoAbortedError
from canopen.variable import Variable
from canopen_bench import IO32, LEVEL_SENSOR, CanopenBench
from canopen_wire import Wire

Connect = Callable[[Path], tuple[Wire, Any]]


def connect(path: Path = IO32, **settings: Any) -> tuple[Wire, Any]:
    wire = Wire(CanopenBench(path, **settings))
    return wire, wire.add_node(5, str(path))


@pytest.mark.parametrize("path", [IO32, LEVEL_SENSOR], ids=lambda path: path.name)
def test_every_object_is_read_with_its_default(path: Path) -> None:
    wire, node = connect(path)
    count = 0
    for ours in wire.bench.node.dictionary:
        if (ours.index == 0x1003 and ours.subindex > 0) or not ours.access.is_readable:
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
        if ours.index in (0x1003, 0x1010, 0x1011) or not ours.access.is_readable:
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
    assert (node.nmt.state, wire.received.count(0x705)) == ("OPERATIONAL", 3)
    node.nmt.send_command(129)
    assert wire.received[-1] == 0x705
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
    assert 0x185 not in wire.received
    wire.sync.transmit()
    assert wire.received[-1] == 0x185
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


# Block transfer, LSS and guarding by the master of python-canopen.

SIZES = [0, 1, 6, 7, 8, 888, 889, 890, 1778, 5000]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("is_checked", [False, True])
def test_domain_goes_both_ways_in_blocks(size: int, is_checked: bool) -> None:
    _, node = connect()
    data = bytes(number * 7 & 0xFF for number in range(size))
    notes = node.sdo[0x2003]
    if size > 0:  # the client of python-canopen sends no segment for empty data
        with notes.open("wb", size=size, block_transfer=True, request_crc_support=is_checked) as file:
            file.write(data)
    with notes.open("rb", block_transfer=True, request_crc_support=is_checked) as file:
        assert file.read() == data


def test_blocks_of_the_size_that_the_node_sets() -> None:
    _, node = connect(sdo_block_size=3)
    data = bytes(range(100))
    with node.sdo[0x2003].open("wb", size=100, block_transfer=True) as file:
        file.write(data)
    assert node.sdo[0x2003].open("rb").read() == data


@pytest.mark.parametrize("lost", [1, 2, 63, 126])
def test_segment_that_is_lost_is_sent_again(lost: int) -> None:
    wire, node = connect()
    wire.lose = {0x605: lost + 1}  # after the initiation
    data = bytes(number * 3 & 0xFF for number in range(1500))
    with node.sdo[0x2003].open("wb", size=len(data), block_transfer=True) as file:
        file.write(data)
    assert node.sdo[0x2003].open("rb").read() == data


def test_eds_is_read_from_the_node_by_block_upload() -> None:
    _, node = connect()
    with node.sdo[0x1021].open("rb", block_transfer=True) as file:
        assert file.read() == IO32.read_bytes()
    assert node.sdo[0x1022].raw == 0


def test_fastscan_finds_the_node_and_gives_it_a_node_id(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("canopen.lss.time.sleep", lambda seconds: None)
    wire = Wire(CanopenBench(node_id=None))
    master: Any = wire.lss
    master.RESPONSE_TIMEOUT = 0.001
    found, identity = master.fast_scan()
    assert (found, identity) == (True, [0, 0x20, 0x10000, 1])
    master.configure_node_id(9)
    master.configure_bit_timing(2)
    master.store_configuration()
    assert master.inquire_node_id() == 255
    master.send_switch_state_global(master.WAITING_STATE)
    assert wire.received[-1] == 0x709


def test_node_is_selected_by_its_identity(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("canopen.lss.time.sleep", lambda seconds: None)
    master: Any = Wire(CanopenBench()).lss
    assert master.send_switch_state_selective(0, 0x20, 0x10000, 1)
    assert (master.inquire_node_id(), master.inquire_lss_address(0x5B)) == (5, 0x20)


@pytest.mark.long
def test_node_answers_to_guarding() -> None:
    wire, node = connect()
    wire.send_message(0x705, b"", remote=True)
    assert node.nmt.state == "PRE-OPERATIONAL"
    node.nmt.state = "OPERATIONAL"
    wire.send_message(0x705, b"", remote=True)
    assert node.nmt.state == "OPERATIONAL"


def test_parameters_are_stored_by_the_client() -> None:
    _, node = connect()
    node.sdo[0x1017].raw = 250
    node.store()
    node.nmt.send_command(129)
    assert node.sdo[0x1017].raw == 250
    node.restore()
    node.nmt.send_command(129)
    assert node.sdo[0x1017].raw == 0


def test_time_is_told_by_the_client() -> None:
    wire, _ = connect()
    canopen.timestamp.TimeProducer(wire).transmit(1_700_000_000.0)
    assert wire.bench.point("time") == "2023-11-14T22:13:20.000"
