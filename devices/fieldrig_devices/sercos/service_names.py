"""One drive's service channel by name: which operation datum a master reads or writes, and with which value.

Source: IEC 61491 by its public facts, as in `service.py`.  The channel is followed from the first handshake that is
seen, and what a master has written is remembered, because it says what the cyclic telegrams carry.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.sercos.datum import Datum
from fieldrig_devices.sercos.idn import Code, Element, idn_text
from fieldrig_devices.sercos.service import AHS, BUSY, ELEMENT_SHIFT, ERROR, LAST, MHS, WRITE

CODES: Final = {int(code): code.name.lower().replace("_", " ") for code in Code}
LONGEST: Final = 4_096
"""Bytes of one element that are collected."""


@dataclass(frozen=True, slots=True)
class _Step:
    element: Element
    is_write: bool
    is_last: bool


class ServiceNames:
    """The service channel of one drive."""

    def __init__(self, table: Mapping[int, Datum]) -> None:
        self._table = table
        self.written: dict[int, bytes] = {}
        """The data that the drive has accepted, by IDN; those of a list without its lengths."""
        self._mhs: int | None = None
        self._step: _Step | None = None
        """The step that the drive has not acknowledged yet."""
        self._idn: int | None = None
        self._buffer = b""

    def on_control(self, control: int, info: int) -> str:
        """Take the low bits of a control word and the two bytes beside it; return what begins, or ""."""
        handshake, before = control & MHS, self._mhs
        self._mhs = handshake
        if before is None or handshake == before:
            return ""
        step = _Step(Element(control >> ELEMENT_SHIFT & 7), bool(control & WRITE), bool(control & LAST))
        is_first = self._step is None or (self._step.element, self._step.is_write) != (step.element, step.is_write)
        self._step = step
        if step.element is Element.CLOSED:
            self._idn, self._buffer = None, b""
            return ""
        if step.element is Element.IDN and step.is_write:
            self._idn, self._buffer = info, b""
            return ""
        if is_first or not self._buffer:
            self._buffer = b""
        if step.is_write:
            self._buffer = (self._buffer + info.to_bytes(2, "little"))[:LONGEST]
            return f"write {self._name} = {self._value(self._buffer)}" if step.is_last else ""
        return f"read {_of(step.element)}{self._name}" if not self._buffer else ""

    def on_status(self, status: int, info: int) -> str:
        """Take the low bits of a status word and the two bytes beside it; return what ends, or ""."""
        step = self._step
        if step is None or status & BUSY or status & AHS != self._mhs:
            return ""
        self._step = None
        if status & ERROR:
            self._buffer = b""
            return f"{self._name}: {info:04X}h {CODES.get(info, 'unknown')}"
        if step.element in (Element.CLOSED, Element.IDN) and (step.is_write or step.element is Element.CLOSED):
            return ""
        if step.is_write:
            return self._accepted() if step.is_last else self._goes_on(step)
        self._buffer = (self._buffer + info.to_bytes(2, "little"))[:LONGEST]
        if not step.is_last:
            return self._goes_on(step)
        data, self._buffer = self._buffer, b""
        value = self._value(data) if step.element is Element.DATA else data.hex(" ").upper()
        return f"{_of(step.element)}{self._name} = {value}"

    def _goes_on(self, step: _Step) -> str:
        self._step = _Step(step.element, step.is_write, is_last=False)
        return ""

    def _accepted(self) -> str:
        data, self._buffer = self._buffer, b""
        if self._idn is not None:
            self.written[self._idn] = self._without_lengths(data)
        return f"{self._name} written"

    @property
    def _name(self) -> str:
        if self._idn is None:
            return "an unknown IDN"
        datum = self._table.get(self._idn)
        return f"{idn_text(self._idn)}{'' if datum is None else f' {datum.name}'}"

    def _without_lengths(self, data: bytes) -> bytes:
        datum = self._table.get(self._idn or 0)
        if datum is None or not datum.attribute.length.is_list:
            return data
        return data[4 : 4 + int.from_bytes(data[:2], "little")]

    def _value(self, data: bytes) -> str:
        datum = self._table.get(self._idn or 0)
        data = self._without_lengths(data)
        if datum is None or (not datum.attribute.length.is_list and len(data) != datum.attribute.length.bytes):
            return data.hex(" ").upper()
        return f"{datum.shown(data)} {datum.unit}".rstrip()


def _of(element: Element) -> str:
    """Return `name of ` for any element but the data."""
    return "" if element is Element.DATA else f"{element.name.lower()} of "
