"""The names of the communication parameters of any node, for tools that meet one without its EDS.

Source: CiA 301 version 4.2, chapter 7.5.2; CiA 302-2 for 1F80h and 1F81h.
"""

from functools import lru_cache
from typing import Final

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.standard import wanted
from fieldrig_devices.canopen.variable import Access, Variable

_IDENTITY: Final = {1: "Vendor-ID", 2: "Product code", 3: "Revision number", 4: "Serial number"}
_PARAMETERS: Final = {
    1: "all parameters", 2: "communication parameters", 3: "application parameters",
}  # fmt: skip
_COMMUNICATION: Final = {
    1: "COB-ID", 2: "Transmission type", 3: "Inhibit time", 5: "Event timer", 6: "SYNC start value",
}  # fmt: skip
_CHANNEL: Final = {1: "COB-ID client to server", 2: "COB-ID server to client", 3: "Node-ID"}
NAMES: Final[list[tuple[range, str, dict[int, str]]]] = [
    (range(0x1000, 0x1001), "Device type", {}),
    (range(0x1001, 0x1002), "Error register", {}),
    (range(0x1002, 0x1003), "Manufacturer status register", {}),
    (range(0x1003, 0x1004), "Pre-defined error field", {}),
    (range(0x1005, 0x1006), "COB-ID SYNC", {}),
    (range(0x1006, 0x1007), "Communication cycle period", {}),
    (range(0x1007, 0x1008), "Synchronous window length", {}),
    (range(0x1008, 0x1009), "Manufacturer device name", {}),
    (range(0x1009, 0x100A), "Manufacturer hardware version", {}),
    (range(0x100A, 0x100B), "Manufacturer software version", {}),
    (range(0x100C, 0x100D), "Guard time", {}),
    (range(0x100D, 0x100E), "Life time factor", {}),
    (range(0x1010, 0x1011), "Store parameters", _PARAMETERS),
    (range(0x1011, 0x1012), "Restore default parameters", _PARAMETERS),
    (range(0x1012, 0x1013), "COB-ID TIME", {}),
    (range(0x1013, 0x1014), "High resolution time stamp", {}),
    (range(0x1014, 0x1015), "COB-ID EMCY", {}),
    (range(0x1015, 0x1016), "Inhibit time EMCY", {}),
    (range(0x1016, 0x1017), "Consumer heartbeat time", {}),
    (range(0x1017, 0x1018), "Producer heartbeat time", {}),
    (range(0x1018, 0x1019), "Identity object", _IDENTITY),
    (range(0x1019, 0x101A), "Synchronous counter overflow value", {}),
    (range(0x1020, 0x1021), "Verify configuration", {1: "Configuration date", 2: "Configuration time"}),
    (range(0x1021, 0x1022), "Store EDS", {}),
    (range(0x1022, 0x1023), "Store format", {}),
    (range(0x1028, 0x1029), "Emergency consumer object", {}),
    (range(0x1029, 0x102A), "Error behavior object", {1: "Communication error"}),
    (range(0x1200, 0x1280), "SDO server {} parameter", _CHANNEL),
    (range(0x1280, 0x1300), "SDO client {} parameter", _CHANNEL),
    (range(0x1400, 0x1600), "RPDO {} communication parameter", _COMMUNICATION),
    (range(0x1600, 0x1800), "RPDO {} mapping parameter", {}),
    (range(0x1800, 0x1A00), "TPDO {} communication parameter", _COMMUNICATION),
    (range(0x1A00, 0x1C00), "TPDO {} mapping parameter", {}),
    (range(0x1F80, 0x1F81), "NMT startup", {}),
    (range(0x1F81, 0x1F82), "NMT slave assignment", {}),
]
_TEXTS: Final = range(0x1008, 0x100B)
_ARRAYS: Final = {0x1003, 0x1016, 0x1028, *range(0x1600, 0x1800), *range(0x1A00, 0x1C00), 0x1F81}
PROFILES: Final = range(0x6000, 0xA000)
"""The objects of device profiles (CiA 301, table 46)."""
UNSIGNED32: Final = 0x07
VISIBLE_STRING: Final = 0x09


class StandardDictionary(Dictionary):
    """The objects that any node has, with the objects of a device profile if its names are known."""

    def __init__(self, profile: Dictionary | None = None) -> None:
        super().__init__([])
        self._profile = profile

    def get(self, index: int, subindex: int = 0) -> Variable | None:
        if index < PROFILES.start:
            return standard_variable(index, subindex)
        return self._profile.get(index, subindex) if self._profile is not None and index in PROFILES else None


@lru_cache(maxsize=4096)
def standard_variable(index: int, subindex: int) -> Variable | None:
    """Return a communication parameter of CiA 301; None for any other object."""
    for indices, name, members in NAMES:
        if index in indices:
            kind = wanted(index, subindex) or DATA_TYPES[VISIBLE_STRING if index in _TEXTS else UNSIGNED32]
            full = _full(name.format(index - indices.start + 1), members, index, subindex)
            return Variable(index, subindex, full, kind, Access.RW, start=b"")
    return None


def _full(name: str, members: dict[int, str], index: int, subindex: int) -> str:
    if subindex == 0:
        return f"{name}, number of entries" if index in _ARRAYS or members else name
    return f"{name}, {members.get(subindex, f'entry {subindex}')}"
