"""The PDOs of a node as rows of its EDS: event-driven, with the identifiers of the predefined connection set."""

from collections.abc import Sequence

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.cia402.eds_file import MAPPED, Table
from fieldrig_devices.cia402.objects import U8, U16, U32, Row

_EVENT_DRIVEN = 255


def pdo_rows(received: Sequence[Sequence[str]], transmitted: Sequence[Sequence[str]], tables: Sequence[Table]) -> Table:
    """Return the parameters and mappings of up to four PDOs of each kind.

    Each PDO is the list of its objects, such as "6200:01", which are rows of `tables`; their mapping may be changed.
    """
    sizes = {(row.index, row.subindex): DATA_TYPES[row.type].bits for table in tables for row in table.rows}
    rows: list[Row] = []
    names: dict[int, str] = {}
    for first, step, kind, pdos in ((0x1400, 0x200, "RPDO", received), (0x1800, 0x180, "TPDO", transmitted)):
        for place, keys in enumerate(pdos):
            index, mapping = first + place, first + 0x200 + place
            names |= {index: f"{kind} {place + 1} parameter", mapping: f"{kind} {place + 1} mapping"}
            rows += [
                Row(index, 1, "COB-ID", U32, "rw", f"$NODEID+{step + 0x100 * place:#x}"),
                Row(index, 2, "Transmission type", U8, "rw", _EVENT_DRIVEN),
                Row(index, 5, "Event timer", U16, "rw"),
                Row(mapping, 0, "Number of mapped objects", U8, "rw", len(keys)),
            ]
            if kind == "TPDO":
                rows.append(Row(index, 3, "Inhibit time", U16, "rw"))
            entries = [_entry(key, sizes) for key in keys]
            entries += [0] * (MAPPED - len(entries))
            for number, entry in enumerate(entries, 1):
                rows.append(Row(mapping, number, f"Mapped object {number}", U32, "rw", f"{entry:#010x}"))
    return Table(rows, names)


def _entry(key: str, sizes: dict[tuple[int, int | None], int | None]) -> int:
    index, subindex = int(key[:4], 16), int(key[5:], 16)
    return index << 16 | subindex << 8 | (sizes[index, subindex] or 0)
