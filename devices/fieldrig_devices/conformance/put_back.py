"""Saves the node's parameters before the suite, and restores them afterwards.

Only values that differ are written, PDO parameters by their procedure.
"""

from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.description import Entry
from fieldrig_devices.conformance.line import Steps
from fieldrig_devices.conformance.objects import (
    RPDO,
    RPDO_MAPPING,
    TPDO,
    TPDO_MAPPING,
    is_command,
)
from fieldrig_devices.conformance.pdo import COB_ID, INVALID
from fieldrig_devices.conformance.verdict import NoAnswer, SdoFault

LATE = (0x1005, 0x1006)
"""Objects to write after 1019h, which cannot be written while they are in use."""
MAPPING_OFFSET = 0x200


class Snapshot:
    def __init__(self) -> None:
        self._values: dict[tuple[int, int], bytes] = {}

    def take(self, bench: Bench) -> Steps[None]:
        """Read all values that can be read and written; errors of reading are tested by a case."""
        for entry in bench.eds:
            if entry.is_readable and entry.is_writable and not is_command(entry):
                try:
                    self._values[entry.index, entry.sub] = yield from bench.sdo.read(entry.index, entry.sub)
                except SdoFault:
                    continue

    def put_back(self, bench: Bench) -> Steps[tuple[int, list[str]]]:
        """Restore the values, and return how many differed and the failures.  Raises NoAnswer for a silent node."""
        differing = yield from self._differing(bench)
        pdos = sorted({_communication(index) for index, _ in differing if _is_pdo(index)})
        others = [key for key in differing if not _is_pdo(key[0])]
        faults: list[str] = []
        if any(index in LATE or index == 0x1019 for index, _ in others):
            faults += yield from _write(bench, 0x1006, 0, bytes(4))
        for key in sorted(others, key=lambda place: (place[0] in LATE, place)):
            faults += yield from _write(bench, *key, self._values[key])
        for index in pdos:
            faults += yield from self._put_back_pdo(bench, index)
        return len(differing), faults

    def _differing(self, bench: Bench) -> Steps[list[tuple[int, int]]]:
        differing: list[tuple[int, int]] = []
        for key, value in self._values.items():
            try:
                now = yield from bench.sdo.read(*key)
            except NoAnswer:
                raise
            except SdoFault:
                continue
            if now != value:
                differing.append(key)
        return differing

    def _put_back_pdo(self, bench: Bench, index: int) -> Steps[list[str]]:
        mapping, faults = index + MAPPING_OFFSET, list[str]()
        cob_id = self._values.get((index, COB_ID))
        if cob_id is not None:
            number = int.from_bytes(cob_id, "little") | INVALID
            faults += yield from _write(bench, index, COB_ID, number.to_bytes(4, "little"))
        if (mapping, 0) in self._values:
            faults += yield from _write(bench, mapping, 0, b"\x00")
        for key in sorted(self._values):
            if (key[0] == mapping and key[1] > 0) or (key[0] == index and key[1] > COB_ID):
                faults += yield from _write(bench, *key, self._values[key])
        for key in ((mapping, 0), (index, COB_ID)):
            if key in self._values:
                faults += yield from _write(bench, *key, self._values[key])
        return faults


def _write(bench: Bench, index: int, sub: int, value: bytes) -> Steps[list[str]]:
    entry: Entry | None = bench.eds.get(index, sub)
    if entry is None or not entry.is_writable:
        return []
    try:
        yield from bench.sdo.write(index, sub, value)
    except NoAnswer:
        raise
    except SdoFault as fault:
        return [f"{entry.key} could not be restored to {value.hex(' ')}: {fault}"]
    return []


def _is_pdo(index: int) -> bool:
    return any(index in indices for indices in (RPDO, RPDO_MAPPING, TPDO, TPDO_MAPPING))


def _communication(index: int) -> int:
    return index - MAPPING_OFFSET if index in RPDO_MAPPING or index in TPDO_MAPPING else index
