"""The parts of an EDS file that all nodes with written object dictionaries share: its head, and the objects of CiA 301.

Source: CiA 306-1 for the sections, CiA 301 for the objects from 1000h to 1FFFh.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.cia402.eds_file import DOMAIN, TEXT, Table
from fieldrig_devices.cia402.objects import U8, U16, U32, Row

_BIT_RATES: Final = {10: 0, 20: 1, 50: 1, 125: 1, 250: 1, 500: 1, 800: 1, 1000: 1}
"""Bit rates in kbit/s, and whether the node has them."""


@dataclass(frozen=True, slots=True)
class NodeFacts:
    """The facts that the sections FileInfo, DeviceInfo and Comments give."""

    file: str
    description: str
    created: str
    """Date as MM-DD-YYYY."""
    vendor: str
    product: str
    product_code: int
    received_pdos: int
    transmitted_pdos: int
    comments: Sequence[str]
    vendor_number: int = 0
    revision: int = 0x0001_0000


def head(facts: NodeFacts) -> str:
    """Return the sections in front of the objects."""
    rates = "\n".join(f"BaudRate_{rate}={is_there}" for rate, is_there in _BIT_RATES.items())
    dummies = "\n".join(f"Dummy{number:04d}={int(number > 1)}" for number in range(1, 8))
    lines = "\n".join(f"Line{number}={line}" for number, line in enumerate(facts.comments, 1))
    return f"""\
[FileInfo]
FileName={facts.file}
FileVersion=1
FileRevision=0
EDSVersion=4.0
Description={facts.description}
CreationTime=10:00AM
CreationDate={facts.created}
CreatedBy=fieldrig
ModificationTime=10:00AM
ModificationDate={facts.created}
ModifiedBy=fieldrig

[DeviceInfo]
VendorName={facts.vendor}
VendorNumber={facts.vendor_number:#010x}
ProductName={facts.product}
ProductNumber={facts.product_code:#010x}
RevisionNumber={facts.revision:#010x}
OrderCode={facts.product}
{rates}
SimpleBootUpMaster=0
SimpleBootUpSlave=1
Granularity=8
DynamicChannelsSupported=0
CompactPDO=0
GroupMessaging=0
NrOfRXPDO={facts.received_pdos}
NrOfTXPDO={facts.transmitted_pdos}
LSS_Supported=0

[DummyUsage]
{dummies}

[Comments]
Lines={len(facts.comments)}
{lines}
"""


def communication(facts: NodeFacts, device_type: int, version: str, more: Sequence[Row] = ()) -> Table:
    """Return the objects of CiA 301 that every such node has, and `more` of them."""
    return Table(
        [
            Row(0x1000, None, "Device type", U32, "ro", f"{device_type:#010x}"),
            Row(0x1001, None, "Error register", U8, "ro"),
            Row(0x1003, 0, "Number of errors", U8, "rw"),
            *(Row(0x1003, number, f"Error {number}", U32, "ro") for number in range(1, 9)),
            Row(0x1005, None, "COB-ID SYNC message", U32, "rw", "0x80"),
            Row(0x1008, None, "Manufacturer device name", TEXT, "const", facts.product),
            Row(0x100A, None, "Manufacturer software version", TEXT, "const", version),
            Row(0x1010, 1, "Save all parameters", U32, "rw", 1),
            Row(0x1011, 1, "Restore all default parameters", U32, "rw", 1),
            Row(0x100C, None, "Guard time", U16, "rw"),
            Row(0x100D, None, "Life time factor", U8, "rw"),
            Row(0x1014, None, "COB-ID EMCY", U32, "rw", "$NODEID+0x80"),
            Row(0x1015, None, "Inhibit time EMCY", U16, "rw"),
            Row(0x1016, 1, "Consumer heartbeat time 1", U32, "rw"),
            Row(0x1016, 2, "Consumer heartbeat time 2", U32, "rw"),
            Row(0x1017, None, "Producer heartbeat time", U16, "rw"),
            Row(0x1018, 1, "Vendor-ID", U32, "ro", "0x00000000"),
            Row(0x1018, 2, "Product code", U32, "ro", f"{facts.product_code:#010x}"),
            Row(0x1018, 3, "Revision number", U32, "ro", "0x00010000"),
            Row(0x1018, 4, "Serial number", U32, "ro"),
            Row(0x1021, None, "Store EDS", DOMAIN, "ro"),
            Row(0x1022, None, "Store format", U8, "ro"),
            Row(0x1029, 1, "Communication error", U8, "rw"),
            Row(0x1200, 1, "COB-ID client to server", U32, "ro", "$NODEID+0x600"),
            Row(0x1200, 2, "COB-ID server to client", U32, "ro", "$NODEID+0x580"),
            Row(0x1F80, None, "NMT startup", U32, "rw", 4),
            *more,
        ],
        {
            0x1003: "Pre-defined error field",
            0x1010: "Store parameters",
            0x1011: "Restore default parameters",
            0x1016: "Consumer heartbeat time",
            0x1018: "Identity object",
            0x1029: "Error behaviour",
            0x1200: "SDO server parameter",
        },
        frozenset({0x1003, 0x1010, 0x1011, 0x1016, 0x1029}),
    )


MORE: Final = (
    Row(0x1006, None, "Communication cycle period", U32, "rw"),
    Row(0x1007, None, "Synchronous window length", U32, "rw"),
    Row(0x1009, None, "Manufacturer hardware version", TEXT, "const", "1"),
    Row(0x1010, 2, "Save communication parameters", U32, "rw", 1),
    Row(0x1010, 3, "Save application parameters", U32, "rw", 1),
    Row(0x1011, 2, "Restore communication default parameters", U32, "rw", 1),
    Row(0x1011, 3, "Restore application default parameters", U32, "rw", 1),
    Row(0x1019, None, "Synchronous counter overflow value", U8, "rw"),
)
"""Objects of CiA 301 besides those of every node."""
