"""The PDOs of the nodes of a bus: which identifier belongs to which PDO of which node.

What the node's parameters say comes first, as an EDS or the recording has them.  Other identifiers are those of the
predefined connection set (CiA 301, 7.3.3).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final, NamedTuple

from fieldrig_devices.canopen.cob_id import EXTENDED
from fieldrig_devices.canopen.pdo import rpdo, tpdo
from fieldrig_devices.canopen.pdo_maps import TO_MAPPING

FIRST_TPDO, FIRST_RPDO, STEP = 0x180, 0x200, 0x100
PREDEFINED: Final = 4
"""PDOs of each direction that the predefined connection set has."""
MOST: Final = 512
SDO_CHANNELS: Final = range(0x1201, 0x1300)
Number = Callable[[int, int], int | None]
"""Returns the value of a parameter of a node by index and sub-index; None if it is not known."""


class Pdo(NamedTuple):
    """A PDO of a node; `number` counts from 1."""

    is_transmitted: bool
    number: int

    @property
    def parameter(self) -> int:
        """Index of its communication parameter."""
        return (tpdo.COMMUNICATION if self.is_transmitted else rpdo.COMMUNICATION) + self.number - 1

    @property
    def mapping(self) -> int:
        return self.parameter + TO_MAPPING

    @property
    def name(self) -> str:
        return f"{'TPDO' if self.is_transmitted else 'RPDO'} {self.number}"

    def predefined(self, node_id: int) -> int | None:
        """The identifier of the predefined connection set; None for a PDO that it lacks."""
        first = FIRST_TPDO if self.is_transmitted else FIRST_RPDO
        return first + (self.number - 1) * STEP + node_id if self.number <= PREDEFINED else None


def is_mapping(index: int) -> bool:
    """True for a mapping parameter."""
    return any(
        first + TO_MAPPING <= index < first + TO_MAPPING + MOST for first in (rpdo.COMMUNICATION, tpdo.COMMUNICATION)
    )


def predefined(identifier: int) -> tuple[int, Pdo] | None:
    """Return node-ID and PDO of an identifier of the predefined connection set."""
    base, node_id = identifier & 0x780, identifier & 0x7F
    for first, is_transmitted in ((FIRST_TPDO, True), (FIRST_RPDO, False)):
        place, rest = divmod(base - first, STEP)
        if not rest and 0 <= place < PREDEFINED and node_id:
            return node_id, Pdo(is_transmitted, place + 1)
    return None


def configured(number: Number, indices: Iterable[int]) -> dict[Pdo, int]:
    """Return the identifiers of the PDOs of a node whose parameters are known; `indices` are the objects of the node.

    A PDO that was switched off in the end keeps its identifier, as its frames may have come before.
    """
    found: dict[Pdo, int] = {}
    for index in indices:
        for first, is_transmitted in ((tpdo.COMMUNICATION, True), (rpdo.COMMUNICATION, False)):
            cob_id = number(index, 1) if first <= index < first + MOST else None
            if cob_id is not None and not cob_id & EXTENDED and cob_id & 0x7FF:
                found[Pdo(is_transmitted, index - first + 1)] = cob_id & 0x7FF
    return found


def sdo_channels(number: Number) -> Iterator[int]:
    """Yield the identifiers of the further SDO channels of a node, as server and as client (CiA 301, 7.5.2.33)."""
    for index in SDO_CHANNELS:
        for cob_id in (number(index, 1), number(index, 2)):
            if cob_id is not None and not cob_id & EXTENDED and cob_id & 0x7FF:
                yield cob_id & 0x7FF


def assigned(
    seen: Mapping[int, int], known: Mapping[int, Mapping[Pdo, int]], nodes: frozenset[int]
) -> tuple[dict[int, dict[Pdo, int]], dict[int, int]]:
    """Return the PDOs of each node with their identifiers, and the identifiers that belong to none, with their counts.

    `seen` has the identifiers of the recording with their counts, `known` the identifiers of the parameters of each
    node, and `nodes` the node-IDs that there are.
    """
    found: dict[int, dict[Pdo, int]] = {node_id: {} for node_id in nodes}
    taken = set[int]()
    for node_id, pdos in known.items():
        for pdo, identifier in pdos.items():
            if identifier in seen and node_id in nodes:
                found[node_id][pdo] = identifier
                taken.add(identifier)
    rest = {}
    for identifier, count in sorted(seen.items()):
        if identifier in taken:
            continue
        usual = predefined(identifier)
        if usual is None or usual[0] not in nodes or known.get(usual[0], {}).get(usual[1], identifier) != identifier:
            rest[identifier] = count
        else:
            found[usual[0]][usual[1]] = identifier
    return found, rest
