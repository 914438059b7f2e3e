"""The PDOs of a bus: which identifier is which PDO of which node, and which objects it carries at which bits.

Source: CiA 301 version 4.2, 7.5.2.35 to 7.5.2.38 (communication and mapping parameters) and 7.3.5 (pre-defined
connection set).  A number that was written or read on the bus counts more than that of the node's EDS.  A node of which
no parameter is known has the identifiers of the pre-defined connection set.
"""

from collections import OrderedDict
from collections.abc import Mapping
from typing import Final, NamedTuple, Protocol

from fieldrig_devices.canopen.cob_id import can_key, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary

RPDO, TPDO = 0x1400, 0x1800
TO_MAPPING: Final = 0x200
"""Distance of the index of the mapping parameter from that of the communication parameter."""
MOST: Final = 512
MOST_MAPPED: Final = 64
MOST_NUMBERS: Final = 16_384
"""Numbers that are remembered; a machine has some thousands."""
PARAMETERS: Final = range(0x1400, 0x1C00)
COB_ID: Final = 1
PREDEFINED: Final = {base | node_id: (node_id, index)
    for base, index in ((0x180, 0x1800), (0x280, 0x1801), (0x380, 0x1802), (0x480, 0x1803),
                        (0x200, 0x1400), (0x300, 0x1401), (0x400, 0x1402), (0x500, 0x1403))
    for node_id in range(1, 128)
}  # fmt: skip
"""Node-ID and communication parameter, by identifier."""


Parameter = tuple[int, int]
"""Node-ID and index of a communication parameter."""


class Pdo(NamedTuple):
    node_id: int
    kind: str
    """Such as `TPDO 1`."""
    mapping: int
    """The index of the mapping parameter."""


Layout = list[tuple[int, int, int, int]]
"""Node-ID, index, sub-index and length in bits of each object in a PDO, in the order of its bits."""


class Accessed(Protocol):
    """An access to an object of a node; an `SdoTransfer` is one."""

    @property
    def node_id(self) -> int: ...
    @property
    def index(self) -> int: ...
    @property
    def subindex(self) -> int: ...
    @property
    def data(self) -> bytes | None: ...
    @property
    def is_done(self) -> bool: ...


class PdoMaps:
    """The PDOs of one bus, as far as they are known now."""

    def __init__(self, dictionaries: Mapping[int, Dictionary] | None = None) -> None:
        """`dictionaries` are those of the nodes that have an EDS, by node-ID."""
        self._dictionaries = dictionaries or {}
        self._numbers: OrderedDict[tuple[int, int, int], int] = OrderedDict()
        """Numbers that were seen on the bus, by node-ID, index and sub-index."""
        self._keys: dict[Parameter, int] = {}
        """The identifier of each PDO whose COB-ID is known; 0 for one that is not valid."""
        self._users: dict[int, dict[Parameter, None]] = {}
        """The PDOs of each identifier."""
        self._pdos: dict[int, Pdo] = {}
        self._layouts: dict[Pdo, Layout | None] = {}
        for node_id, dictionary in self._dictionaries.items():
            for index in (*dictionary.indices(TPDO, TPDO + MOST - 1), *dictionary.indices(RPDO, RPDO + MOST - 1)):
                self._move(node_id, index)

    def take(self, transfer: Accessed) -> bool:
        """Learn from a completed read or write of a parameter; True if that may have changed a PDO."""
        if not transfer.is_done or not transfer.data:
            return False
        number = int.from_bytes(transfer.data[:4], "little")
        return self.put(transfer.node_id, transfer.index, transfer.subindex, number)

    def put(self, node_id: int, index: int, subindex: int, number: int) -> bool:
        """Take into account that a parameter has this number now; True if that may have changed a PDO."""
        key = node_id, index, subindex
        if index not in PARAMETERS or self._numbers.get(key) == number:
            return False
        self._numbers[key] = number
        self._changed(*key)
        if len(self._numbers) > MOST_NUMBERS:
            self._changed(*self._numbers.popitem(last=False)[0])
        return True

    def _changed(self, node_id: int, index: int, subindex: int) -> None:
        self._layouts.clear()
        if subindex == COB_ID and not index & TO_MAPPING:
            self._move(node_id, index)

    def _move(self, node_id: int, index: int) -> None:
        """Give a PDO the identifier that its COB-ID has now."""
        parameter, cob_id = (node_id, index), self._number(node_id, index, COB_ID)
        before = self._keys.pop(parameter, 0)
        key = can_key(cob_id) if cob_id is not None and is_valid(cob_id) else 0
        if cob_id is not None:
            self._keys[parameter] = key
        if before:
            del self._users[before][parameter]
            if not self._users[before]:
                del self._users[before]
        if key:
            self._users.setdefault(key, {})[parameter] = None
        self._pdos.clear()

    def knows(self, node_id: int, index: int, subindex: int) -> bool:
        """Return whether this number was seen on the bus."""
        return (node_id, index, subindex) in self._numbers

    def pdo_of(self, key: int) -> Pdo | None:
        """Return the PDO with an identifier, where bit 31 marks one of 29 bits; the producer if there are several."""
        found = self._pdos.get(key) or self._find(key)
        if found is not None:
            self._pdos[key] = found
        return found

    def layout_of(self, key: int) -> Layout | None:
        """Return what a PDO carries; None if that is not known, and an empty list for a PDO without mapped objects."""
        pdo = self.pdo_of(key)
        return None if pdo is None else self.layout(pdo)

    def layout(self, pdo: Pdo) -> Layout | None:
        """Return what a PDO carries, as `layout_of` does."""
        if pdo not in self._layouts:
            self._layouts[pdo] = self._read(pdo)
        return self._layouts[pdo]

    def _read(self, pdo: Pdo) -> Layout | None:
        count = self._number(pdo.node_id, pdo.mapping, 0)
        if count is None or count > MOST_MAPPED:  # above are multiplexed PDOs
            return None
        mapped = [self._number(pdo.node_id, pdo.mapping, subindex) for subindex in range(1, count + 1)]
        if None in mapped:
            return None
        return [(pdo.node_id, entry >> 16, entry >> 8 & 0xFF, entry & 0xFF) for entry in mapped if entry is not None]

    def _find(self, key: int) -> Pdo | None:
        users = self._users.get(key)
        if users:
            return _pdo(*min(users, key=lambda parameter: parameter[1] < TPDO))
        parameter = PREDEFINED.get(key)
        if parameter is None or parameter[0] in self._dictionaries or parameter in self._keys:
            return None
        return _pdo(*parameter)

    def _number(self, node_id: int, index: int, subindex: int) -> int | None:
        seen = self._numbers.get((node_id, index, subindex))
        if seen is not None or node_id not in self._dictionaries:
            return seen
        variable = self._dictionaries[node_id].get(index, subindex)
        return None if variable is None else variable.number


def _pdo(node_id: int, index: int) -> Pdo:
    first, word = (TPDO, "TPDO") if index >= TPDO else (RPDO, "RPDO")
    return Pdo(node_id, f"{word} {index - first + 1}", index + TO_MAPPING)
