"""Creates a rig with one CANopen node or one drive from an EDS or DCF file."""

import json
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from string import Template

from fieldrig.cli.common import reading
from fieldrig.errors import UsageError
from fieldrig.text.device_names import name_for
from fieldrig_devices.canopen.eds import reader as eds
from fieldrig_devices.canopen.eds.commissioning import commissioned
from fieldrig_devices.cia402.single.foreign import is_drive

BIT_RATES = (500_000, 250_000, 1_000_000, 125_000, 800_000, 50_000, 20_000, 10_000)
"""Bit rates in order of preference: the first that the file supports is used."""
DEVICE_TYPE = 0x1000
DRIVE_NOTE = """\
note: the file describes a drive (CiA 402), so the node is a `cia402.drive` with a motor and a load of its own.
`fieldrig devices cia402.drive` lists its keys, and `fieldrig check` says what is odd in the file."""
NODE_ID = 1
"""The node-ID for an EDS file; a DCF file has its own."""

RIG = Template("""\
# $what from $eds, on a CAN bus that your own master can join.
# `fieldrig up $name.yaml` starts it and prints its connections; `fieldrig check $name.yaml` explains mistakes.
time: real                        # the clock of this host

buses:
  can0:
    kind: can.hub                 # `fieldrig devices can.hub` lists its settings, and those of other kinds
    bitrate: $bit_rate
    socketcand: 127.0.0.1:29536   # python-can, canopen and others join here

devices:
  $name:
    kind: $kind
    node_id: $node_id
    eds: $eds
    links: {can: can0}
    objects: {}                   # power-on values that replace those of the file, such as "1017:00": 1000 (heartbeat)
""")

TEST = Template('''\
"""The node of $name.yaml in virtual time, seen from a master on its CAN bus."""

from pathlib import Path

from fieldrig import RigMaker, S
from fieldrig_bus.can import CanFrame

RIG = Path(__file__).with_name("$name.yaml")
NODE_ID = $node_id
READ_1000H = bytes.fromhex("40 00 10 00 00 00 00 00")
DEVICE_TYPE = bytes.fromhex("43 00 10 00 $device_type")


def test_the_node_boots(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    received: list[CanFrame] = []
    rig.attach("master").link("can0").on_receive(received.append, interest=[(0x700 + NODE_ID, 0x7FF)])
    rig.run_until(1 * S)
    assert received[0].data == b"\\x00"


def test_a_master_reads_the_device_type_by_sdo(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(RIG)
    rig.run_until(1 * S)
    received: list[CanFrame] = []
    can = rig.attach("master").link("can0")
    can.on_receive(received.append, interest=[(0x580 + NODE_ID, 0x7FF)])
    can.send(CanFrame(0x600 + NODE_ID, READ_1000H))
    rig.run_until(2 * S)
    assert [frame.data for frame in received] == [DEVICE_TYPE]
''')


def content_for(file: Path) -> Mapping[PurePosixPath, bytes]:
    """Return the files of the rig by path, the rig file first.  Raises UsageError if no node fits the EDS file."""
    try:
        with reading(file, "expected an EDS or DCF file"):
            node_id, bit_rate = commissioned(file)
            node_id = node_id or NODE_ID
            dictionary = eds.load(file, node_id)
            data = file.read_bytes()
    except ValueError as cause:
        remedy = f"`fieldrig eds check {file}` says what to write instead"
        raise UsageError(f"no node can be made from {file}:\n{cause}", remedy) from cause
    rates = dictionary.features.bit_rates
    name = name_for(file)
    is_a_drive = is_drive(dictionary)
    words = {
        "what": "One drive (CiA 402)" if is_a_drive else "One CANopen node",
        "kind": "cia402.drive" if is_a_drive else "canopen.node",
        "name": name,
        "eds": json.dumps(f"eds/{file.name}", ensure_ascii=False),
        "node_id": node_id,
        "bit_rate": bit_rate or next((rate for rate in BIT_RATES if rate in rates), BIT_RATES[0]),
        "device_type": dictionary.number(DEVICE_TYPE, 0).to_bytes(4, "little").hex(" "),
    }
    return {
        PurePosixPath(f"{name}.yaml"): RIG.substitute(words).encode(),
        PurePosixPath(f"test_{name.replace('-', '_')}.py"): TEST.substitute(words).encode(),
        PurePosixPath("eds", file.name): data,
    }


def note_for(file: Path) -> str:
    """Return what else the user should know about the rig of the EDS file; empty if there is nothing to say."""
    return DRIVE_NOTE if is_drive(eds.load(file, NODE_ID)) else ""
