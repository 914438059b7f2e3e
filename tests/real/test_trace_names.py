"""Dialogues and names of a log against Wireshark's dissectors of CANopen and Modbus, which read the same capture."""

import subprocess
from pathlib import Path
from typing import Any, Final

import pytest
from canopen.sdo.exceptions import SdoAbortedError
from canopen_bench import IO32, CanopenBench
from canopen_wire import Wire
from logs import can_entry, modbus_log

from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse, OnModbus
from fieldrig_devices.dialogues import ModbusExchange, SdoTransfer, dialogues
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.rows import Rows

pytestmark = pytest.mark.real

CANOPEN: Final = ("-d", "can.subdissector,canopen")
A_DAY_NS: Final = 10**18
"""Captures have the time of day."""


def dissected(path: Path, fields: tuple[str, ...], *options: str) -> list[list[str]]:
    """Return these fields of each packet, as tshark shows them."""
    names = [word for field in fields for word in ("-e", field)]
    command = ["tshark", "-r", str(path), *options, "-T", "fields", *names]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return [line.split("\t") for line in done.stdout.splitlines()]


@pytest.fixture(scope="module")
def canopen_log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A master of python canopen that reads every object of a node, writes some, and is refused."""
    bench = CanopenBench(objects={"1017:00": 100})
    wire = Wire(bench)
    wire.run(0)
    node: Any = wire.add_node(5, str(IO32))
    for variable in bench.node.dictionary:
        is_long = variable.index == 0x1021  # the EDS, in thousands of segments
        if variable.access.is_readable and not is_long and not (variable.index == 0x1003 and variable.subindex):
            node.sdo.upload(variable.index, variable.subindex)
        wire.run(1)
    with node.sdo[0x1008].open("rb", block_transfer=True) as file:
        file.read()
    with pytest.raises(SdoAbortedError):
        node.sdo.download(0x1000, 0, b"1234")
    wire.nmt.state = "OPERATIONAL"
    wire.run(500)
    path = tmp_path_factory.mktemp("log") / "canopen.pcapng"
    write([can_entry(A_DAY_NS + time_ns, frame) for time_ns, frame in wire.frames], path)
    return path


def test_transfers_have_the_objects_that_wireshark_shows(canopen_log: Path) -> None:
    """Except for blocks, which Wireshark does not follow: it takes the last segment of one for an abort."""
    fields = ("canopen.sdo.main_idx", "canopen.sdo.sub_idx", "canopen.sdo.abort_code")
    packets = dissected(canopen_log, fields, *CANOPEN)
    found = [one for one in dialogues(read(canopen_log)) if isinstance(one, SdoTransfer)]
    assert len(found) > 50
    blocks = {number for transfer in found if transfer.form == "block" for number in transfer.entries}
    assert len(blocks) > 5
    for transfer in found:
        if transfer.form == "block":
            continue
        index, subindex, _ = packets[transfer.entries[0]]
        assert (transfer.index, transfer.subindex) == (int(index, 0), int(subindex, 0))
        abort = packets[transfer.entries[-1]][2]
        assert transfer.abort == (int(abort, 0) if abort else None)
    assert {transfer.form for transfer in found} == {"expedited", "segmented", "block"}
    aborts = [number for number, packet in enumerate(packets) if packet[2] and number not in blocks]
    assert aborts == [transfer.entries[-1] for transfer in found if transfer.abort is not None]


def test_services_are_those_that_wireshark_shows(canopen_log: Path) -> None:
    """In the column of the protocol's information Wireshark names the service of each frame."""
    packets = dissected(canopen_log, ("_ws.col.Info",), *CANOPEN)
    words = {"SDO": "sdo", "TPDO": "pdo", "RPDO": "pdo", "NMT": "nmt", "heartbeat": "heartbeat", "boot-up": "heartbeat"}
    told = {"sdo": "SDO", "pdo": "PDO", "nmt": "NMT", "heartbeat": "NMT Error Control"}
    for row in Rows(NamedLog(), every_frame=True).of(read(canopen_log)):
        if row.kind:
            service = words[row.kind.split()[0]]
            assert told[service] in packets[row.entries[0]][0]


READ, VALUE, REFUSED = b"\x03\x00\x6b\x00\x01", b"\x03\x02\x00\x01", b"\x83\x02"


def entries_of_two_clients() -> list[TraceEntry]:
    messages: list[tuple[str, OnModbus]] = [
        ("a", ModbusRequest(1, READ, 7)),
        ("b", ModbusRequest(2, READ, 7)),
        ("m", ModbusResponse(2, VALUE, 7)),
        ("m", ModbusResponse(1, VALUE, 7)),
        ("a", ModbusRequest(1, READ, 8)),
        ("m", ModbusResponse(1, REFUSED, 8)),
        ("a", ModbusRequest(1, READ, 9)),
    ]
    return [entry._replace(time_ns=entry.time_ns + A_DAY_NS) for entry in modbus_log(messages)]


def test_exchanges_have_the_requests_and_times_that_wireshark_shows(tmp_path: Path) -> None:
    path = tmp_path / "modbus.pcapng"
    write(entries_of_two_clients(), path)
    packets = dissected(path, ("modbus.request_frame", "modbus.response_time", "modbus.exception_code"))
    found = [one for one in dialogues(read(path)) if isinstance(one, ModbusExchange)]
    for exchange in found:
        if exchange.end_ns is None:
            assert exchange.request == READ
            continue
        request, *_ = exchange.entries
        frame, seconds, exception = packets[exchange.entries[-1]]
        assert exchange.exception == (int(exception) if exception else None)
        if frame:  # the dissector of an exception does not look for its request
            assert int(frame) == request + 1
            assert exchange.end_ns - exchange.begin_ns == round(float(seconds) * 1e9)
    assert [exchange.entries for exchange in found] == [(1, 2), (0, 3), (4, 5), (6,)]
