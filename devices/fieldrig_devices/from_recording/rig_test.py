"""The test beside a rig of a recording: its devices are there, and answer as in the recording."""

from collections.abc import Sequence
from string import Template
from typing import Final

from fieldrig_devices.from_recording.parts import RigPart

TEST: Final = Template('''\
"""The devices of $name.yaml in virtual time answer as in the recording."""

from pathlib import Path

import pytest

from fieldrig import RigMaker, S
$imports
RIG = Path(__file__).with_name("$name.yaml")
BOOTED_S = $booted_s
$tests''')
NODE_TEST: Final = Template("""
NODES = $rows


@pytest.mark.parametrize(("bus", "node_id"), NODES)
def test_the_node_is_there(fieldrig_rig: RigMaker, bus: str, node_id: int) -> None:
    rig = fieldrig_rig(RIG)
    received: list[CanFrame] = []
    rig.attach("master").link(bus).on_receive(received.append, interest=[(0x700 + node_id, 0x7FF)])
    rig.run_until(BOOTED_S * S)
    assert received[0].data == b"\\x00"
""")
READ_TEST: Final = Template("""
READS = $rows


@pytest.mark.parametrize(("bus", "node_id", "request_", "data"), READS)
def test_a_master_reads_what_was_recorded(
    fieldrig_rig: RigMaker, bus: str, node_id: int, request_: str, data: str
) -> None:
    rig = fieldrig_rig(RIG)
    rig.run_until(BOOTED_S * S)
    received: list[CanFrame] = []
    can = rig.attach("master").link(bus)
    can.on_receive(received.append, interest=[(0x580 + node_id, 0x7FF)])
    for _ in range(2):  # a drive may lose the first request
        can.send(CanFrame(0x600 + node_id, bytes.fromhex(request_)))
        rig.run_for(1 * S)
    expected = bytes.fromhex(data)
    assert received[0].data[4 : 4 + len(expected)] == expected
""")
MODBUS_TEST: Final = Template("""
REQUESTS = $rows


@pytest.mark.parametrize(("bus", "unit", "request_", "response"), REQUESTS)
def test_a_master_gets_the_recorded_response(
    fieldrig_rig: RigMaker, bus: str, unit: int, request_: str, response: str
) -> None:
    rig = fieldrig_rig(RIG)
    rig.run_until(BOOTED_S * S)
    received: list[ModbusResponse] = []
    master = rig.attach("master").link(bus)
    master.on_receive(received.append)
    master.send(ModbusRequest(unit, bytes.fromhex(request_)))
    rig.until(lambda: received, within=60 * S)
    assert received[0].pdu == bytes.fromhex(response)
""")


def test_of(name: str, parts: Sequence[RigPart]) -> str:
    """Return the text of the test of the rig with this name."""
    can = [part for part in parts if part.is_can]
    modbus = [part for part in parts if not part.is_can]
    imports = "from fieldrig_bus.can import CanFrame\n" if can else ""
    backs = [back for part in modbus for back in part.read_backs]
    imports += "from fieldrig_bus.modbus import ModbusRequest, ModbusResponse\n" if backs else ""
    tests = "\n".join(
        template.substitute(rows=_listed(rows))
        for template, rows in (
            (NODE_TEST, [(part.name, node_id) for part in can for node_id in part.nodes]),
            (READ_TEST, [back for part in can for back in part.read_backs]),
            (MODBUS_TEST, backs),
        )
        if rows
    )
    booted_s = max(part.booted_s for part in parts)
    return TEST.substitute(name=name, imports=imports, tests=tests, booted_s=booted_s)


def _listed(rows: Sequence[tuple[object, ...]]) -> str:
    return "\n".join(["[", *(f"    {_row(row)}," for row in rows), "]"])


def _row(row: tuple[object, ...]) -> str:
    words = (f'"{word}"' if isinstance(word, str) else str(word) for word in row)
    return f"({', '.join(words)})"
