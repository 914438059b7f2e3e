"""Finds an object that doesn't fit into one SDO message, for the cases of longer transfers."""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.verdict import Aborted


def long_object(bench: Bench) -> Steps[Entry]:
    """Return the longest readable object of more than four bytes up to 1 KiB.  Not applicable if there is none."""
    found: list[tuple[int, Entry]] = []
    for entry in bench.eds:
        if entry.is_readable and (entry.size is None or entry.size > 4):
            try:
                initiated = yield from bench.sdo.initiate_upload(entry.index, entry.sub)
            except Aborted:
                continue  # another case tests this
            if initiated[0] & 0x02:
                continue
            bench.sdo.abort(entry.index, entry.sub)
            size = int.from_bytes(initiated[4:], "little") if initiated[0] & 1 else 5
            if size > 4:
                found.append((size if size <= 1024 else 0, entry))
    if not found:
        bench.skip("no readable object of the EDS has more than four bytes")
    return max(found, key=lambda pair: pair[0])[1]
