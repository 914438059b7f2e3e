"""Creates a rig with one Modbus device from a list of registers in a CSV file."""

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from string import Template

from fieldrig.cli.common import reading
from fieldrig.errors import UsageError
from fieldrig.text.device_names import name_for
from fieldrig_devices.begin.register_list import RegisterList, read_list
from fieldrig_devices.registers.table import SPACES

RIG = Template("""\
# One Modbus device from $list, that your own master can read on Modbus TCP.
# `fieldrig up $name.yaml` starts it and prints its connections; `fieldrig check $name.yaml` explains mistakes.
time: real                        # the clock of this host

buses:
  modbus:
    kind: modbus.tcp              # `fieldrig devices modbus.tcp` lists its settings; modbus.rtu is a serial line
    listen: 127.0.0.1:5020

devices:
  $name:
    kind: modbus.device
    table: registers/$name.yaml
    unit_id: 1
    links: {modbus: modbus}
""")

TEST = Template('''\
"""The device of $name.yaml in virtual time, seen from a master."""

from pathlib import Path

from fieldrig import RigMaker
from fieldrig_bus.modbus import ModbusRequest, ModbusResponse

RIG = Path(__file__).with_name("$name.yaml")


def test_a_master_reads_$point(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    received: list[ModbusResponse] = []
    master = rig.attach("master").link("modbus")
    master.on_receive(received.append)
    master.send(ModbusRequest(1, bytes.fromhex("$request")))  # function $function at address $address
    rig.until(lambda: received, within=1_000_000_000)
    assert received[0].pdu[0] == $function
''')
FUNCTIONS = dict(zip(SPACES, (1, 2, 3, 4), strict=True))


def content_for(file: Path) -> tuple[Mapping[PurePosixPath, bytes], list[str]]:
    """Return the files of the rig by path, the rig file first, and the notes on the list.

    UsageError if the file is no list of registers.
    """
    try:
        with reading(file, "expected a CSV file"):
            made = read_list(file)
        request = _request(made)
    except ValueError as cause:
        remedy = "expected CSV with names of columns in the first line: address, name, type, unit, scale"
        raise UsageError(f"{file} is no list of registers:\n{cause}", remedy) from cause
    name = name_for(file)
    words = {"name": name, "list": file.name, **request}
    return {
        PurePosixPath(f"{name}.yaml"): RIG.substitute(words).encode(),
        PurePosixPath(f"test_{name.replace('-', '_')}.py"): TEST.substitute(words).encode(),
        PurePosixPath("registers", f"{name}.yaml"): made.text(file.name).encode(),
    }, made.notes


def _request(made: RegisterList) -> Mapping[str, object]:
    """Return the words of a request that reads the first entry that clients can read."""
    for space in SPACES:
        for entry in made.entries[space]:
            if entry.get("access") != "wo":
                function, address = FUNCTIONS[space], entry["address"]
                pdu = bytes((function, *address.to_bytes(2, "big"), 0, 1))
                return {
                    "point": entry["name"],
                    "request": pdu.hex(" "),
                    "function": function,
                    "address": address,
                }
    raise ValueError("no client can read any of its registers")
