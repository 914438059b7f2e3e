"""EDS checker: the file that the node is measured by.

Source: CiA 306-1 4.4 to 4.6.
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.description import BITS, Entry
from fieldrig_devices.conformance.line import Steps

MANDATORY = (0x1000, 0x1001, 0x1018)
ACCESSES = ("ro", "wo", "rw", "rwr", "rww", "const")
ARBITRARY = (0x09, 0x0A, 0x0B, 0x0F)
"""VISIBLE_STRING, OCTET_STRING, UNICODE_STRING, DOMAIN."""


@case(
    "1.0",
    "EDS checker",
    "The EDS has the mandatory objects, and each of its entries a type, an access type, and a default within limits.",
    "CiA 306-1 4.6; CiA 301 7.5.1",
)
def eds_file(bench: Bench) -> Steps[None]:
    missing = [f"{index:04X}h" for index in MANDATORY if index not in bench.eds]
    bench.check(not missing, "1000h, 1001h and 1018h in the EDS", f"no {', '.join(missing)}")
    faults = [fault for entry in bench.eds for fault in _faults(entry)]
    bench.check(not faults, "an EDS without faults", "; ".join(faults[:5]))
    yield from bench.wait(0)


def _faults(entry: Entry) -> list[str]:
    faults: list[str] = []
    if entry.type not in BITS and entry.type not in ARBITRARY:
        faults.append(f"{entry.key}: data type {entry.type:04X}h")
    if entry.access not in ACCESSES:
        faults.append(f"{entry.key}: access type {entry.access}")
    if entry.is_mappable and entry.access == "const" and entry.index > 0x1FFF:
        faults.append(f"{entry.key}: a constant with PDOMapping=1")
    if entry.is_integer and entry.default is not None:
        value = int.from_bytes(entry.default, "little", signed=entry.range[0] < 0)
        if not (entry.range[0] if entry.low is None else entry.low) <= value:
            faults.append(f"{entry.key}: default {value} below the LowLimit {entry.low}")
        if not value <= (entry.range[1] if entry.high is None else entry.high):
            faults.append(f"{entry.key}: default {value} above the HighLimit {entry.high}")
    return faults
