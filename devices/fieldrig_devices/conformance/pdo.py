"""The PDOs of the EDS, and their configuration by the suite.

Source: CiA 301 7.5.2.35 to 7.5.2.38.
"""

from dataclasses import dataclass
from typing import NamedTuple

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.objects import RPDO, RPDO_MAPPING, TPDO, TPDO_MAPPING
from fieldrig_devices.conformance.verdict import Aborted, NotApplicable

INVALID, NO_RTR, EXTENDED = 1 << 31, 1 << 30, 1 << 29
COB_ID, TYPE, INHIBIT, EVENT_TIMER, SYNC_START = 1, 2, 3, 5, 6
"""Sub-indices of PDO communication parameters."""
EVENT_DRIVEN = 255
MAX_BITS = 64
INVALID_VALUE = 0x0609_0030
FIRST_IDS = {True: 0x180, False: 0x200}
"""First identifiers of the pre-defined connection set; the key is True for TPDOs."""


class Pdo(NamedTuple):
    number: int
    """Number of the PDO, from 0."""
    is_transmit: bool

    @property
    def communication(self) -> int:
        return (TPDO if self.is_transmit else RPDO)[self.number]

    @property
    def mapping(self) -> int:
        return (TPDO_MAPPING if self.is_transmit else RPDO_MAPPING)[self.number]

    @property
    def name(self) -> str:
        return f"{'T' if self.is_transmit else 'R'}PDO {self.number + 1}"


@dataclass(frozen=True, slots=True)
class Mapped:
    index: int
    sub: int
    bits: int

    @property
    def number(self) -> int:
        return self.index << 16 | self.sub << 8 | self.bits


def pdos(bench: Bench, is_transmit: bool) -> list[Pdo]:
    objects = TPDO if is_transmit else RPDO
    return [Pdo(index - objects[0], is_transmit) for index in bench.eds.indices(objects[0], objects[-1])]


def read_mapping(bench: Bench, pdo: Pdo) -> Steps[list[Mapped]]:
    count = yield from bench.read(pdo.mapping, 0)
    mapped: list[Mapped] = []
    for sub in range(1, min(count, MAX_BITS) + 1):
        number = yield from bench.read(pdo.mapping, sub)
        mapped.append(Mapped(number >> 16, number >> 8 & 0xFF, number & 0xFF))
    return mapped


def size(mapped: list[Mapped]) -> int:
    """Return the length of a PDO with this mapping, in bytes."""
    return (sum(variable.bits for variable in mapped) + 7) // 8


def identifier(cob_id: int) -> int:
    return cob_id & (0x1FFF_FFFF if cob_id & EXTENDED else 0x7FF)


def default_cob_id(bench: Bench, pdo: Pdo) -> int:
    """Return the COB-ID of the pre-defined connection set, for the first four PDOs, without RTR."""
    flag = NO_RTR if pdo.is_transmit else 0
    return flag | FIRST_IDS[pdo.is_transmit] + 0x100 * pdo.number + bench.node_id


def invalidate(bench: Bench, pdo: Pdo) -> Steps[int]:
    """Make the PDO invalid, and return the COB-ID that makes it valid again."""
    cob_id = yield from bench.read(pdo.communication, COB_ID)
    if not cob_id & INVALID:
        yield from bench.change(pdo.communication, COB_ID, cob_id | INVALID)
        return cob_id
    cob_id &= ~INVALID
    return cob_id if identifier(cob_id) > 0x180 else default_cob_id(bench, pdo)


def configure(
    bench: Bench, pdo: Pdo, kind: int, *, event_ms: int = 0, sync_start: int = 0, with_rtr: bool = False
) -> Steps[int]:
    """Configure a TPDO, and return its CAN identifier.  Not applicable if the EDS or the node doesn't permit it."""
    base = pdo.communication
    bench.entry(base, COB_ID, writable=True)
    bench.entry(base, TYPE, writable=True)
    cob_id = yield from invalidate(bench, pdo)
    try:
        yield from bench.change(base, TYPE, kind)
    except Aborted as abort:
        if abort.code == INVALID_VALUE:
            bench.skip(f"{pdo.name} doesn't support transmission type {kind}: the node refuses it with 0609 0030h")
        raise
    for sub, value in ((EVENT_TIMER, event_ms), (SYNC_START, sync_start)):
        entry = bench.eds.get(base, sub)
        if entry is not None and entry.is_writable:
            yield from bench.change(base, sub, value)
        elif value:
            bench.entry(base, sub, writable=True)
    if with_rtr:
        cob_id &= ~NO_RTR
    try:
        yield from bench.change(base, COB_ID, cob_id)
    except Aborted as abort:
        if with_rtr and abort.code == INVALID_VALUE:
            bench.skip(f"{pdo.name} doesn't support RTR: the node refuses bit 30 at 0 with 0609 0030h")
        raise
    return identifier(cob_id)


def usable_tpdos(bench: Bench, at_most: int = 4) -> Steps[list[Pdo]]:
    """Return the TPDOs with a mapping.  Not applicable if there are none."""
    usable: list[Pdo] = []
    for pdo in pdos(bench, is_transmit=True):
        mapped = yield from read_mapping(bench, pdo)
        if mapped and len(usable) < at_most:
            usable.append(pdo)
    if not usable:
        bench.skip("the EDS has no TPDO with a mapped object")
    return usable


def mappable(bench: Bench, is_transmit: bool, accesses: tuple[str, ...]) -> list[Entry]:
    """Return the entries with these access types that can be mapped."""
    return [entry for entry in bench.eds if entry.is_mappable and entry.access in accesses and entry.pdo_bits > 0]


def as_mapped(entry: Entry) -> Mapped:
    return Mapped(entry.index, entry.sub, entry.pdo_bits)


def changeable(bench: Bench, is_transmit: bool) -> Pdo:
    """Return a PDO whose mapping can be changed according to the EDS.  Not applicable if there is none."""
    for pdo in pdos(bench, is_transmit):
        parameters = (bench.eds.get(pdo.mapping, 0), bench.eds.get(pdo.mapping, 1), bench.eds.get(pdo.communication, 1))
        if all(parameter is not None and parameter.is_writable for parameter in parameters):
            return pdo
    sort = "TPDO" if is_transmit else "RPDO"
    raise NotApplicable(f"the EDS has no {sort} whose mapping can be changed")


def map_to(bench: Bench, pdo: Pdo, wanted: list[Mapped]) -> Steps[int]:
    """Perform the mapping procedure up to sub-index 0, and return the COB-ID that makes the PDO valid."""
    cob_id = yield from invalidate(bench, pdo)
    yield from bench.change(pdo.mapping, 0, 0)
    for sub, mapped in enumerate(wanted, 1):
        yield from bench.change(pdo.mapping, sub, mapped.number)
    yield from bench.change(pdo.mapping, 0, len(wanted))
    return cob_id
