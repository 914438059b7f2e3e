"""Finds what is odd in the EDS or DCF file of a drive, each with its line.

A master may fail on it; the drive runs all the same.

Source: CiA 402-2 for the objects and their types.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from fieldrig_devices.canopen.datatypes import DATA_TYPES
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.eds import reader
from fieldrig_devices.canopen.eds.finding import Finding, warning
from fieldrig_devices.canopen.eds.source import EdsSource, Section
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import find
from fieldrig_devices.cia402.objects import ROWS, Row
from fieldrig_devices.cia402.single.foreign import DEVICE_TYPE, FEWEST_INCREMENTS, NEVER_0
from fieldrig_devices.drive_profile.objects import AXIS_STEP, is_drive_type

_NEEDED: Final = {
    objects.CONTROL_WORD: "no master can enable the drive",
    objects.STATUS_WORD: "no master sees the state of the drive",
    objects.MODE: "the drive stays without a mode of operation",
    objects.MODE_DISPLAY: "no master sees the mode of operation",
}


def oddities(path: Path) -> list[Finding]:
    """Return the findings in the order of their lines.  Raises EdsError if the file is refused."""
    description = reader.describe(path, reader.CHECKED_AS)
    look = _Look(EdsSource(path), Dictionary(description.variables), description.given)
    return sorted((*look.profile(), *look.needed(), *look.modes(), *look.rows(), *look.encoder()), key=_line)


def _line(finding: Finding) -> int:
    return finding.line


class _Look:
    def __init__(self, source: EdsSource, dictionary: Dictionary, given: frozenset[tuple[int, int]]) -> None:
        self._source, self._dictionary, self._given = source, dictionary, given

    def _at(self, index: int, subindex: int | None = None, key: str = "") -> tuple[int, str, str]:
        """Line, section and key for a finding about an object; line 1 if the file does not have it."""
        names = [f"{index:04X}"] if subindex is None else [f"{index:04X}sub{subindex:X}", f"{index:04X}"]
        section = next((found for name in names if (found := self._source.get(name)) is not None), None)
        if section is None:
            return 1, names[0], ""
        return section.line_of(key), section.name, key if section.get(key) else ""

    def _value_key(self, index: int, subindex: int | None) -> str:
        name = f"{index:04X}" if subindex is None else f"{index:04X}sub{subindex:X}"
        section: Section | None = self._source.get(name)
        return "ParameterValue" if section is not None and section.get("ParameterValue") else "DefaultValue"

    def profile(self) -> Iterator[Finding]:
        type = self._dictionary.number(DEVICE_TYPE, 0)
        place = self._at(DEVICE_TYPE, key=self._value_key(DEVICE_TYPE, None))
        if not is_drive_type(type):
            what = f"the device type {type:#010x} is not that of a drive"
            yield warning(*place, what, "expected 0x192 (CiA 402) in its low word; some masters refuse the node")
        if objects.CONTROL_WORD + AXIS_STEP in self._dictionary:
            place = self._at(objects.CONTROL_WORD + AXIS_STEP)
            yield warning(*place, "the file describes several axes", "only the first one has a motor here")

    def needed(self) -> Iterator[Finding]:
        for index, effect in _NEEDED.items():
            if index not in self._dictionary:
                yield warning(1, f"{index:04X}", "", "the object is missing", f"{effect}; CiA 402 requires it")

    def modes(self) -> Iterator[Finding]:
        variable = self._dictionary.get(objects.SUPPORTED_MODES)
        if variable is None or not variable.number or (objects.SUPPORTED_MODES, 0) not in self._given:
            place = self._at(objects.SUPPORTED_MODES)
            what = "is missing" if variable is None else "has no default"
            yield warning(*place, f"6502h (supported drive modes) {what}", "the objects that exist decide on the modes")
        mode = self._dictionary.get(objects.MODE)
        if mode is not None and not mode.is_mappable:
            yield warning(*self._at(objects.MODE, key="PDOMapping"), "6060h is not mappable", "masters write it by SDO")

    def rows(self) -> Iterator[Finding]:
        for row in ROWS:
            variable = find(self._dictionary, row)
            if variable is not None:
                yield from self._types(row, variable)
                yield from self._zeros(row, variable)
            elif self._dictionary.get(row.index, row.subindex or 0) is not None:
                place = self._at(row.index, row.subindex, "DataType")
                remedy = f"expected {DATA_TYPES[row.type].name}; the drive does not use it"
                yield warning(*place, "does not hold a whole number", remedy)

    def _types(self, row: Row, variable: Variable) -> Iterator[Finding]:
        """An array is named once, by its first element."""
        wanted = DATA_TYPES[row.type]
        if variable.type is not wanted and (row.subindex or 1) == 1:
            what = f"{variable.key} is {variable.type.name}"
            remedy = f"CiA 402 has {wanted.name}; a master that knows only that fails"
            yield warning(*self._at(row.index, row.subindex, "DataType"), what, remedy)
        if row.subindex == 1 and variable.subindex == 0:
            what = f"{row.index:04X}h is a plain variable"
            remedy = "CiA 402 has an array; sub-index 0 counts as its first element"
            yield warning(*self._at(row.index), what, remedy)

    def _zeros(self, row: Row, variable: Variable) -> Iterator[Finding]:
        if self._is_unknown(row) and not variable.number:
            place = self._at(row.index, row.subindex, self._value_key(row.index, row.subindex))
            remedy = "the drive works with a value of its own"
            yield warning(*place, f"{variable.key} is 0, with which nothing would move", remedy)

    def _is_unknown(self, row: Row) -> bool:
        return row.index in NEVER_0 and row.index != objects.FOLLOWING_WINDOW

    def encoder(self) -> Iterator[Finding]:
        counts = self._dictionary.get(objects.ENCODER_RESOLUTION, 1)
        if counts is not None and counts.number < FEWEST_INCREMENTS:
            place = self._at(objects.ENCODER_RESOLUTION, 1, self._value_key(objects.ENCODER_RESOLUTION, 1))
            what = f"608Fh gives {counts.number} increments for a turn"
            remedy = "the key encoder_increments says what the encoder has; default: 4096"
            yield warning(*place, what, remedy)
        feed = self._dictionary.get(objects.FEED_CONSTANT, 1)
        if feed is not None and feed.number <= 1:
            place = self._at(objects.FEED_CONSTANT, 1, self._value_key(objects.FEED_CONSTANT, 1))
            what = f"6092h gives {feed.number} units for a turn"
            yield warning(*place, what, "it counts as not set, so user units are increments")
