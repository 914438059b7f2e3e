"""PDO 01, 02, 21: the present parameters of PDOs.

Source: CiA 301 7.5.2.35 to 7.5.2.38, 7.3.3 (pre-defined connection set).
"""

from functools import partial

from fieldrig_devices.conformance import pdo as pdos
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.pdo import COB_ID, INVALID, MAX_BITS, TYPE, Mapped, Pdo

RESERVED_TYPES = {True: range(241, 252), False: range(241, 254)}
"""Reserved transmission types; the key is True for TPDOs."""


@case(
    "3.21",
    "PDO 21",
    "The mapped objects exist, can be mapped, have the length of the mapping entry, and fit into the PDO.",
    "CiA 301 7.5.2.36, 7.5.2.38",
)
def default_mapping(bench: Bench) -> Steps[None]:
    every = [*pdos.pdos(bench, is_transmit=False), *pdos.pdos(bench, is_transmit=True)]
    if not every:
        bench.skip("the EDS has no PDO")
    for pdo in every:
        mapped = yield from pdos.read_mapping(bench, pdo)
        total = sum(variable.bits for variable in mapped)
        bench.check(total <= MAX_BITS, f"at most 64 bits in {pdo.name}", str(total))
        for variable in mapped:
            yield from _check_mapped(bench, pdo, variable)


def _scan(bench: Bench, is_transmit: bool) -> Steps[None]:
    found = pdos.pdos(bench, is_transmit)
    if not found:
        bench.skip(f"the EDS has no {'TPDO' if is_transmit else 'RPDO'}")
    for pdo in found:
        highest = yield from bench.read(pdo.communication, 0)
        bench.check(2 <= highest <= 6, f"2 to 6 in {pdo.communication:04X}h:00h", str(highest))
        cob_id = yield from bench.read(pdo.communication, COB_ID)
        entry = bench.eds.get(pdo.communication, COB_ID)
        if entry is not None and entry.default is not None:
            right = int.from_bytes(entry.default, "little")
            bench.check(cob_id == right, f"COB-ID {right:08X}h of {pdo.name}, as in the EDS", f"{cob_id:08X}h")
        is_usable = bool(cob_id & INVALID) or 0x180 < pdos.identifier(cob_id) < 0x6E0 or bool(cob_id & pdos.EXTENDED)
        bench.check(is_usable, f"a valid CAN-ID of a PDO in {pdo.name}", f"{cob_id:08X}h")
        kind = yield from bench.read(pdo.communication, TYPE)
        is_known = kind not in RESERVED_TYPES[is_transmit]
        bench.check(is_known, f"a transmission type in {pdo.name} that is not reserved", str(kind))


def _check_mapped(bench: Bench, pdo: Pdo, mapped: Mapped) -> Steps[None]:
    name = f"{mapped.index:04X}h:{mapped.sub:02X}h in {pdo.name}"
    if mapped.index in bench.eds.dummies and not pdo.is_transmit:
        return
    entry = bench.eds.get(mapped.index, mapped.sub)
    if entry is None:
        bench.fail(f"{name} to be in the EDS", "no such object")
    bench.check(entry.is_mappable, f"PDOMapping=1 for {name}", "PDOMapping=0")
    wrong = ("wo", "rww") if pdo.is_transmit else ("ro", "rwr", "const")
    bench.check(entry.access not in wrong, f"an access type that allows {name}", entry.access)
    right = entry.pdo_bits
    bench.check(mapped.bits in (right, entry.size and entry.size * 8) or not right, f"{right} bits", str(mapped.bits))
    if entry.is_readable:
        data = yield from bench.sdo.read(entry.index, entry.sub)
        bench.check(entry.size in (None, len(data)), f"{entry.size} bytes of {name} by SDO", data.hex(" "))


for number, name, is_transmit, clause in (
    (1, "RPDO", False, "CiA 301 7.5.2.35"),
    (2, "TPDO", True, "CiA 301 7.5.2.37"),
):
    requirement = f"Each {name} of the EDS exists, with a valid COB-ID and a transmission type that is not reserved."
    case(f"3.{number}", f"PDO {number:02d}", requirement, clause)(partial(_scan, is_transmit=is_transmit))
