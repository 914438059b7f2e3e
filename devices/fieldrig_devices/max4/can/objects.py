"""The object dictionary of the CAN face: the objects of a node besides its axes, and the EDS file of all objects.

Source: CiA 301, CiA 402-3 (device type of several axes); 2000h to 21FFh are ours (docs/cia402.md).
`python -m fieldrig_devices.max4.can.objects` writes the file.
"""

from pathlib import Path
from typing import Final

from fieldrig_devices.cia402.eds_file import DOMAIN, OCTETS, TEXT, Table, axis_objects, pdo_objects, write
from fieldrig_devices.cia402.objects import AXES, EMPTY_PDOS, I32, RECEIVED, TRANSMITTED, U8, U16, U32, Row

EDS: Final = Path(__file__).with_name("max4-axes.eds")
REAL64: Final = 0x11

CONTROLLER: Final = 0x2000
"""Sub-indices: 1 DiagCode, 2 DiagExtCode, 3 DiagMsg, 4 acknowledge (quit) all, 5 booted."""
MESSAGE: Final = 0x2001
"""Sub-indices: 1 number of the entry to show, 1 is the newest; 2 the entry; 3 number of entries."""
PARAMETER: Final = 0x2002
"""Sub-indices: 1 logical address, 2 path, 3 type, 4 value as a number, 5 value as a text, 6 kind of access."""
AXIS: Final = 0x2100
"""First index of the objects of the axes, one per axis."""
SERVICE: Final = 0x2180
"""First index of the service channels, one per axis."""

FIRST_PARAMETER: Final = 0x1_0001
"""Logical address that is selected first: MsgFilter, the first parameter of the controller."""
SEVERAL_AXES: Final = 0xFFFF_0192
"""Value of 1000h for a device with several CiA 402 axes."""
PRODUCT: Final = 0x0000_4D34

_HEAD: Final = f"""\
[FileInfo]
FileName=max4-axes.eds
FileVersion=1
FileRevision=0
EDSVersion=4.0
Description=MAx-4 PacController, axes as a CiA 402 device
CreationTime=10:00AM
CreationDate=11-21-2026
CreatedBy=fieldrig
ModificationTime=10:00AM
ModificationDate=11-21-2026
ModifiedBy=fieldrig

[DeviceInfo]
VendorName=ELAU
VendorNumber=0x00000000
ProductName=MAx-4
ProductNumber={PRODUCT:#010x}
RevisionNumber=0x00010000
OrderCode=MAx-4
BaudRate_10=0
BaudRate_20=1
BaudRate_50=1
BaudRate_125=1
BaudRate_250=1
BaudRate_500=1
BaudRate_800=1
BaudRate_1000=1
SimpleBootUpMaster=0
SimpleBootUpSlave=1
Granularity=8
DynamicChannelsSupported=0
CompactPDO=0
GroupMessaging=0
NrOfRXPDO={AXES * (len(RECEIVED) + EMPTY_PDOS)}
NrOfTXPDO={AXES * (len(TRANSMITTED) + EMPTY_PDOS)}
LSS_Supported=0

[DummyUsage]
Dummy0001=0
Dummy0002=1
Dummy0003=1
Dummy0004=1
Dummy0005=1
Dummy0006=1
Dummy0007=1

[Comments]
Lines=3
Line1=Up to eight axes of a MAx-4; the manual describes no objects, so the layout is fieldrig's (docs/cia402.md).
Line2=Axis n from 0 has its objects at 6000h + n x 800h and its PDOs from number n x 64 + 1 on.
Line3=Axes that a node has not show 0 in 67FFh + n x 800h and stay not ready to switch on.
"""

_COMMUNICATION: Final = Table(
    [
        Row(0x1000, None, "Device type", U32, "ro", f"{SEVERAL_AXES:#010x}"),
        Row(0x1001, None, "Error register", U8, "ro"),
        Row(0x1003, 0, "Number of errors", U8, "rw"),
        *(Row(0x1003, number, f"Error {number}", U32, "ro") for number in range(1, 9)),
        Row(0x1005, None, "COB-ID SYNC message", U32, "rw", "0x80"),
        Row(0x1006, None, "Communication cycle period", U32, "rw"),
        Row(0x1007, None, "Synchronous window length", U32, "rw"),
        Row(0x1008, None, "Manufacturer device name", TEXT, "const", "MAx-4"),
        Row(0x1009, None, "Manufacturer hardware version", TEXT, "const", "1"),
        Row(0x100A, None, "Manufacturer software version", TEXT, "const", "V00.15.00"),
        Row(0x1010, 1, "Save all parameters", U32, "rw", 1),
        Row(0x1010, 2, "Save communication parameters", U32, "rw", 1),
        Row(0x1010, 3, "Save application parameters", U32, "rw", 1),
        Row(0x1011, 1, "Restore all default parameters", U32, "rw", 1),
        Row(0x1011, 2, "Restore communication default parameters", U32, "rw", 1),
        Row(0x1011, 3, "Restore application default parameters", U32, "rw", 1),
        Row(0x100C, None, "Guard time", U16, "rw"),
        Row(0x100D, None, "Life time factor", U8, "rw"),
        Row(0x1014, None, "COB-ID EMCY", U32, "rw", "$NODEID+0x80"),
        Row(0x1015, None, "Inhibit time EMCY", U16, "rw"),
        Row(0x1016, 1, "Consumer heartbeat time 1", U32, "rw"),
        Row(0x1016, 2, "Consumer heartbeat time 2", U32, "rw"),
        Row(0x1017, None, "Producer heartbeat time", U16, "rw"),
        Row(0x1018, 1, "Vendor-ID", U32, "ro", "0x00000000"),
        Row(0x1018, 2, "Product code", U32, "ro", f"{PRODUCT:#010x}"),
        Row(0x1018, 3, "Revision number", U32, "ro", "0x00010000"),
        Row(0x1018, 4, "Serial number", U32, "ro"),
        Row(0x1019, None, "Synchronous counter overflow value", U8, "rw"),
        Row(0x1021, None, "Store EDS", DOMAIN, "ro"),
        Row(0x1022, None, "Store format", U8, "ro"),
        Row(0x1029, 1, "Communication error", U8, "rw"),
        Row(0x1200, 1, "COB-ID client to server", U32, "ro", "$NODEID+0x600"),
        Row(0x1200, 2, "COB-ID server to client", U32, "ro", "$NODEID+0x580"),
        Row(0x1F80, None, "NMT startup", U32, "rw", 4),
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

_CONTROLLER: Final = Table(
    [
        Row(CONTROLLER, 1, "DiagCode", U16, "ro", is_mappable=True),
        Row(CONTROLLER, 2, "DiagExtCode", TEXT, "ro"),
        Row(CONTROLLER, 3, "DiagMsg", TEXT, "ro"),
        Row(CONTROLLER, 4, "Quit controller and all axes", U8, "wo", low=0, high=1),
        Row(CONTROLLER, 5, "Boot has finished", U8, "ro", is_mappable=True),
        Row(MESSAGE, 1, "Which entry, 1 is the newest", U16, "rw", 1, low=1),
        Row(MESSAGE, 2, "Entry", TEXT, "ro"),
        Row(MESSAGE, 3, "Number of entries", U16, "ro"),
        Row(PARAMETER, 1, "Logical address", U32, "rw", f"{FIRST_PARAMETER:#010x}"),
        Row(PARAMETER, 2, "Path", TEXT, "rw"),
        Row(PARAMETER, 3, "Type of value", U8, "ro"),
        Row(PARAMETER, 4, "Value as a number", REAL64, "rw", ""),
        Row(PARAMETER, 5, "Value as a text", TEXT, "rw"),
        Row(PARAMETER, 6, "Kind of access", U8, "ro"),
    ],
    {CONTROLLER: "Controller", MESSAGE: "Message logger", PARAMETER: "Parameter by its logical address"},
)


def _axis(axis: int) -> Table:
    """The manufacturer-specific objects of one axis."""
    name = f"Axis {axis + 1}"
    state, service = AXIS + axis, SERVICE + axis
    return Table(
        [
            Row(state, 1, "DiagCode", U16, "ro", is_mappable=True),
            Row(state, 2, "DiagMsg", TEXT, "ro"),
            Row(state, 3, "Quit", U8, "wo", low=0, high=1),
            Row(state, 4, "AxisState", U8, "ro", is_mappable=True),
            Row(state, 5, "MC4State", U8, "ro", is_mappable=True),
            Row(state, 6, "Symbolic name", TEXT, "ro"),
            Row(state, 7, "Logical address", U32, "ro"),
            Row(state, 8, "RealTimeBusAdr", U8, "ro"),
            Row(service, 1, "IDN", U16, "rw"),
            Row(service, 2, "Element", U8, "rw", 7, low=1, high=7),
            Row(service, 3, "Order: 1 read, 2 write", U8, "wo", low=0, high=2),
            Row(service, 4, "State: 0 idle, 1 under way, 2 done, 3 refused", U8, "ro", is_mappable=True),
            Row(service, 5, "Service channel error", U16, "ro"),
            Row(service, 6, "Data", OCTETS, "rw"),
            Row(service, 7, "Data as a number", I32, "rw"),
        ],
        {state: f"{name}: MC-4", service: f"{name}: service channel"},
    )


def eds_text() -> str:
    axes = [table(axis) for axis in range(AXES) for table in (axis_objects, pdo_objects, _axis)]
    return write(_HEAD, [_COMMUNICATION, _CONTROLLER, *axes])


if __name__ == "__main__":
    EDS.write_text(eds_text())
