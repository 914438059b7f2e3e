"""PDO 22 to 33: changing the mapping of PDOs.

Source: CiA 301 7.5.2.36, 7.5.2.38 (the mapping procedure), 7.4.7 (dummy mapping), CiA 306-1 4.6.3 (access types).
The node may refuse an impossible mapping when the entry is written, or when sub-index 0 is.
"""

from functools import partial

from fieldrig_devices.conformance import nmt, sync
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.nmt import State
from fieldrig_devices.conformance.pdo import (
    COB_ID,
    MAX_BITS,
    TYPE,
    Mapped,
    Pdo,
    as_mapped,
    changeable,
    identifier,
    invalidate,
    map_to,
    mappable,
    pdos,
    read_mapping,
    size,
)
from fieldrig_devices.conformance.verdict import NotApplicable

READ_ONLY, UNSUPPORTED, DEVICE_STATE, LOCAL_CONTROL = 0x0601_0002, 0x0601_0000, 0x0800_0022, 0x0800_0021
NOT_MAPPABLE, TOO_LONG, INCOMPATIBLE = 0x0604_0041, 0x0604_0042, 0x0604_0043
INVALID_VALUE, TOO_HIGH = 0x0609_0030, 0x0609_0031
OUT_OF_ORDER = (UNSUPPORTED, DEVICE_STATE, LOCAL_CONTROL, INCOMPATIBLE, READ_ONLY)
PROCEDURE = "CiA 301 7.5.2.36, 7.5.2.38"
INTO_TPDO, INTO_RPDO = ("ro", "rwr"), ("rww", "wo")
EITHER_WAY = ("rw",)


@case("3.22", "PDO 22", "A valid mapping, written by the procedure, is accepted and used.", PROCEDURE)
def new_mapping(bench: Bench) -> Steps[None]:
    pdo, wanted = _other_mapping(bench)
    cob_id = yield from map_to(bench, pdo, wanted)
    came = yield from read_mapping(bench, pdo)
    bench.check(came == wanted, f"{_text(wanted)} in {pdo.name}", _text(came))
    if pdo.is_transmit and sync.COB_ID in bench.eds:
        yield from _check_it_is_used(bench, pdo, cob_id, wanted)
    else:
        yield from bench.change(pdo.communication, COB_ID, cob_id)


@case("3.23", "PDO 23", "An entry of a mapping cannot be written while sub-index 0 is not 0.", PROCEDURE)
def without_the_procedure(bench: Bench) -> Steps[None]:
    pdo, wanted = _other_mapping(bench)
    yield from invalidate(bench, pdo)
    count = yield from bench.read(pdo.mapping, 0)
    if count == 0:
        yield from map_to(bench, pdo, wanted[:1])
    other = next(iter(_others(bench, pdo, (yield from bench.read(pdo.mapping, 1)))), wanted[0])
    attempt = bench.change(pdo.mapping, 1, other.number)
    yield from bench.refuses(attempt, *OUT_OF_ORDER, what=f"writing {pdo.mapping:04X}h:01h while :00h is not 0")


@case("3.24", "PDO 24", "The mapping of a valid PDO cannot be changed.", PROCEDURE)
def valid_pdo(bench: Bench) -> Steps[None]:
    pdo, wanted = _other_mapping(bench)
    cob_id = yield from invalidate(bench, pdo)
    yield from bench.change(pdo.communication, COB_ID, cob_id)
    yield from bench.refuses(_rewrite(bench, pdo, wanted), *OUT_OF_ORDER, what=f"a new mapping of the valid {pdo.name}")


@case("3.25", "PDO 25", "More objects than a PDO can carry are refused.", PROCEDURE)
def too_many(bench: Bench) -> Steps[None]:
    pdo, _ = _other_mapping(bench)
    yield from invalidate(bench, pdo)
    yield from bench.change(pdo.mapping, 0, 0)
    count = len(bench.eds.members(pdo.mapping)) + 1
    attempt = bench.change(pdo.mapping, 0, count)
    codes = (TOO_LONG, NOT_MAPPABLE, INCOMPATIBLE, INVALID_VALUE, TOO_HIGH)
    yield from bench.refuses(attempt, *codes, what=f"{count} objects in {pdo.name}")


@case("3.26", "PDO 26", "Objects with more than 64 bits in total are refused.", PROCEDURE)
def too_long(bench: Bench) -> Steps[None]:
    pdo, _ = _other_mapping(bench)
    longest = max(_right(bench, pdo), key=lambda mapped: mapped.bits)
    count = MAX_BITS // longest.bits + 1
    if count > len(bench.eds.members(pdo.mapping)):
        bench.skip(f"{pdo.name} has too few entries for more than 64 bits")
    attempt = map_to(bench, pdo, [longest] * count)
    yield from bench.refuses(attempt, TOO_LONG, what=f"{count * longest.bits} bits in {pdo.name}")


@case("3.33", "PDO 33", "A dummy that the EDS allows can be mapped to an RPDO.", "CiA 301 7.4.7; CiA 306-1 4.5.3")
def dummy(bench: Bench) -> Steps[None]:
    if not bench.eds.dummies:
        bench.skip("the EDS allows no dummies (DummyUsage)")
    pdo = changeable(bench, is_transmit=False)
    bits, index = max((bits, index) for index, bits in bench.eds.dummies.items())
    wanted = [Mapped(index, 0, bits)]
    yield from map_to(bench, pdo, wanted)
    came = yield from read_mapping(bench, pdo)
    bench.check(came == wanted, f"{_text(wanted)} in {pdo.name}", _text(came))


def _accept_objects(bench: Bench, is_transmit: bool) -> Steps[None]:
    pdo, accesses = changeable(bench, is_transmit), INTO_TPDO if is_transmit else INTO_RPDO
    entries = mappable(bench, is_transmit, accesses)
    if not entries:
        bench.skip(f"the EDS has no object with AccessType {' or '.join(accesses)} and PDOMapping=1")
    wanted = [as_mapped(entries[-1])]
    yield from map_to(bench, pdo, wanted)
    came = yield from read_mapping(bench, pdo)
    bench.check(came == wanted, f"{_text(wanted)} in {pdo.name}", _text(came))


def _refuse_other_direction(bench: Bench, is_transmit: bool) -> Steps[None]:
    accesses = INTO_RPDO if is_transmit else INTO_TPDO
    entries = mappable(bench, is_transmit, accesses)
    yield from _refused(bench, is_transmit, entries, f"AccessType {' or '.join(accesses)} and PDOMapping=1")


def _refuse_unmappable(bench: Bench, is_transmit: bool) -> Steps[None]:
    accesses = ("ro", "rw", "rwr") if is_transmit else ("rw", "rww", "wo")
    entries = [entry for entry in bench.eds if _is_unmappable(entry) and entry.access in accesses]
    yield from _refused(bench, is_transmit, entries, f"AccessType {' or '.join(accesses)} and PDOMapping=0")


def _refused(bench: Bench, is_transmit: bool, entries: list[Entry], what: str) -> Steps[None]:
    pdo = changeable(bench, is_transmit)
    if not entries:
        bench.skip(f"the EDS has no object with {what}")
    attempt = map_to(bench, pdo, [as_mapped(entries[0])])
    yield from bench.refuses(attempt, NOT_MAPPABLE, what=f"{entries[0].key} ({entries[0].access}) in {pdo.name}")


def _is_unmappable(entry: Entry) -> bool:
    return not entry.is_mappable and entry.pdo_bits > 1


def _other_mapping(bench: Bench) -> tuple[Pdo, list[Mapped]]:
    """Return a PDO whose mapping can be changed, and a valid mapping: the last and first object that it may carry."""
    for is_transmit in (True, False):
        for pdo in pdos(bench, is_transmit)[:1]:
            right = _right(bench, pdo)
            if right:
                changed = changeable(bench, is_transmit)
                return changed, _fitting(right[-1:] + right[:1])[: len(bench.eds.members(changed.mapping))]
    raise NotApplicable("the EDS has no PDO with an object that can be mapped to it")


def _right(bench: Bench, pdo: Pdo) -> list[Mapped]:
    accesses = (INTO_TPDO if pdo.is_transmit else INTO_RPDO) + EITHER_WAY
    return [as_mapped(entry) for entry in mappable(bench, pdo.is_transmit, accesses) if entry.pdo_bits % 8 == 0]


def _others(bench: Bench, pdo: Pdo, present: int) -> list[Mapped]:
    return [mapped for mapped in _right(bench, pdo) if mapped.number != present]


def _fitting(mapped: list[Mapped]) -> list[Mapped]:
    return mapped if sum(variable.bits for variable in mapped) <= MAX_BITS else mapped[:1]


def _rewrite(bench: Bench, pdo: Pdo, wanted: list[Mapped]) -> Steps[None]:
    """Write a mapping by the procedure, except for the COB-ID."""
    yield from bench.change(pdo.mapping, 0, 0)
    for sub, mapped in enumerate(wanted, 1):
        yield from bench.change(pdo.mapping, sub, mapped.number)
    yield from bench.change(pdo.mapping, 0, len(wanted))


def _check_it_is_used(bench: Bench, pdo: Pdo, cob_id: int, wanted: list[Mapped]) -> Steps[None]:
    yield from bench.change(pdo.communication, TYPE, 1)
    yield from bench.change(pdo.communication, COB_ID, cob_id)
    sync_id = yield from sync.consume(bench)
    overflow = yield from sync.overflow(bench)
    yield from nmt.enter(bench, State.OPERATIONAL)
    bench.send(sync_id, b"\x01" if overflow else b"")
    frame = yield from bench.expect(identifier(cob_id))
    expected = f"{pdo.name} with {size(wanted)} bytes"
    bench.check(
        frame is not None and len(frame.data) == size(wanted),
        expected,
        "none" if frame is None else frame.data.hex(" "),
    )


def _text(mapped: list[Mapped]) -> str:
    return ", ".join(f"{variable.number:08X}h" for variable in mapped) or "nothing"


RULES = (
    (27, _accept_objects, False, "Objects for RPDOs (rww, wo) can be mapped to an RPDO."),
    (28, _refuse_other_direction, False, "Objects for TPDOs (rwr, ro) cannot be mapped to an RPDO."),
    (29, _refuse_unmappable, False, "Objects with PDOMapping=0 cannot be mapped to an RPDO."),
    (30, _accept_objects, True, "Objects for TPDOs (rwr, ro) can be mapped to a TPDO."),
    (31, _refuse_other_direction, True, "Objects for RPDOs (rww, wo) cannot be mapped to a TPDO."),
    (32, _refuse_unmappable, True, "Objects with PDOMapping=0 cannot be mapped to a TPDO."),
)
"""PDO 27 to 32: number, steps, direction (True for TPDOs), and requirement."""

for number, steps, is_transmit, requirement in RULES:
    register = case(f"3.{number}", f"PDO {number}", requirement, f"{PROCEDURE}; CiA 306-1 4.6.3")
    register(partial(steps, is_transmit=is_transmit))
