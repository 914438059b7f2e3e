"""An EDS written from tables of objects, and the PDOs of CiA 402 axes.

Source: CiA 306-1; CiA 402-3 for PDOs.  The PDOs of the first axis have the identifiers of the predefined connection
set of CiA 301; all others are not valid until a master assigns them one.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.objects import ARRAYS, NAMES, PDO_STEP, ROWS, U8, U16, U32, Row
from fieldrig_devices.drive_profile.objects import AXIS_STEP

OCTETS: Final = 0x0A
TEXT: Final = 0x09
DOMAIN: Final = 0x0F
NOT_VALID: Final = "0x80000000"
MAPPED: Final = 8
"""Largest number of entries in a mapping."""
_MANDATORY: Final = (0x1000, 0x1001, 0x1018)
_RPDO, _RPDO_MAPPING, _TPDO, _TPDO_MAPPING = 0x1400, 0x1600, 0x1800, 0x1A00
_FIRST_OF_APPLICATION: Final = 0x2000
_SYNCHRONOUS, _EVENT_DRIVEN = 1, 255
_INHIBIT: Final = 50
"""Inhibit time of 5 ms, so that a position that changes in every cycle does not fill the bus."""


class Table(NamedTuple):
    """Rows of objects.  `names` lists the objects with sub-indices, `arrays` those of them that are arrays."""

    rows: Sequence[Row]
    names: Mapping[int, str]
    arrays: frozenset[int] = frozenset()


def axis_objects(axis: int, rows: Sequence[Row] = ROWS, *, is_only: bool = False) -> Table:
    """The objects of axis `axis`, counted from 0.  Their names begin with its number, unless it is the only one."""
    up = axis * AXIS_STEP
    prefix = "" if is_only else f"Axis {axis + 1}: "
    return Table(
        [replace(row, index=row.index + up, name=f"{prefix}{row.name}") for row in rows],
        {index + up: f"{prefix}{name}" for index, name in NAMES.items()},
        frozenset(index + up for index in ARRAYS),
    )


def pdo_objects(axis: int) -> Table:
    rows: list[Row] = []
    names: dict[int, str] = {}
    first = axis * PDO_STEP
    empty: list[tuple[int, ...]] = [()] * objects.EMPTY_PDOS
    for place, indices in enumerate([*objects.RECEIVED, *empty], first):
        rows += [
            *_parameter(_RPDO + place, 0x200, place, _EVENT_DRIVEN),
            *_mapping(_RPDO_MAPPING + place, indices, axis),
        ]
        names |= {_RPDO + place: f"RPDO {place + 1} parameter", _RPDO_MAPPING + place: f"RPDO {place + 1} mapping"}
    for place, indices in enumerate([*objects.TRANSMITTED, *empty], first):
        is_event_driven = bool(indices) and place - first not in objects.SYNCHRONOUS
        type = _EVENT_DRIVEN if is_event_driven or not indices else _SYNCHRONOUS
        rows += _parameter(_TPDO + place, 0x180, place, type, objects.EVENT_TIMER_MS if is_event_driven else 0)
        rows.insert(-1, Row(_TPDO + place, 3, "Inhibit time", U16, "rw", _INHIBIT if place - first >= 2 else 0))
        rows += _mapping(_TPDO_MAPPING + place, indices, axis)
        names |= {_TPDO + place: f"TPDO {place + 1} parameter", _TPDO_MAPPING + place: f"TPDO {place + 1} mapping"}
    return Table(rows, names)


def _parameter(index: int, cob_id: int, place: int, type: int, event_timer: int = 0) -> list[Row]:
    is_predefined = place < len(objects.RECEIVED)
    start = f"$NODEID+{cob_id + 0x100 * place:#x}" if is_predefined else NOT_VALID
    return [
        Row(index, 1, "COB-ID", U32, "rw", start),
        Row(index, 2, "Transmission type", U8, "rw", type),
        Row(index, 5, "Event timer", U16, "rw", event_timer),
    ]


def _mapping(index: int, indices: Sequence[int], axis: int) -> Iterator[Row]:
    yield Row(index, 0, "Number of mapped objects", U8, "rw", len(indices))
    for subindex in range(1, MAPPED + 1):
        entry = _entry(indices[subindex - 1], axis) if subindex <= len(indices) else 0
        yield Row(index, subindex, f"Mapped object {subindex}", U32, "rw", f"{entry:#010x}")


def _entry(index: int, axis: int) -> int:
    row = next(row for row in ROWS if row.index == index)
    return (index + axis * AXIS_STEP) << 16 | (DATA_TYPES[row.type].bits or 0)


def write(head: str, tables: Iterable[Table]) -> str:
    """The text of the file; `head` contains the sections that describe the file and the device."""
    rows: dict[int, list[Row]] = {}
    names: dict[int, str] = {}
    arrays: set[int] = set()
    for table in tables:
        names |= table.names
        arrays |= table.arrays
        for row in table.rows:
            rows.setdefault(row.index, []).append(row)
    blocks = [head.strip(), *_lists(sorted(rows))]
    for index in sorted(rows):
        blocks += _object(index, rows[index], names, index in arrays)
    return "\n\n".join(blocks) + "\n"


def _lists(indices: Sequence[int]) -> Iterator[str]:
    ours = [index for index in indices if 0x2000 <= index < 0x6000]
    others = [index for index in indices if index not in _MANDATORY and index not in ours]
    for name, listed in (("MandatoryObjects", _MANDATORY), ("OptionalObjects", others), ("ManufacturerObjects", ours)):
        lines = [f"{place}=0x{index:04X}" for place, index in enumerate(listed, 1)]
        yield "\n".join([f"[{name}]", f"SupportedObjects={len(lines)}", *lines])


def _object(index: int, rows: Sequence[Row], names: Mapping[int, str], is_array: bool) -> Iterator[str]:
    if rows[0].subindex is None:
        yield _variable(f"{index:04X}", rows[0])
        return
    if all(row.subindex != 0 for row in rows):
        highest = max(row.subindex or 0 for row in rows)
        rows = [Row(index, 0, "Highest sub-index supported", U8, "const", highest), *rows]
    kind = "0x8" if is_array else "0x9"
    yield f"[{index:04X}]\nParameterName={names[index]}\nObjectType={kind}\nSubNumber={len(rows)}"
    for row in sorted(rows, key=lambda row: row.subindex or 0):
        yield _variable(f"{index:04X}sub{row.subindex:X}", row)


def _variable(section: str, row: Row) -> str:
    lines = [f"[{section}]", f"ParameterName={row.name}", f"ObjectType={'0x2' if row.type == DOMAIN else '0x7'}"]
    lines += [f"DataType=0x{row.type:04X}", f"AccessType={row.access}"]
    lines += [f"LowLimit={row.low}"] if row.low is not None else []
    lines += [f"HighLimit={row.high}"] if row.high is not None else []
    lines += [f"DefaultValue={row.start}"] if _has_start(row) else []
    return "\n".join([*lines, f"PDOMapping={int(row.is_mappable)}"])


def _has_start(row: Row) -> bool:
    """True unless the machine supplies the value, which is not known in advance."""
    is_supplied = row.access == "ro" and row.index >= _FIRST_OF_APPLICATION
    return bool(row.start) if is_supplied or row.type == TEXT else row.start != "" and row.type not in (DOMAIN, OCTETS)
