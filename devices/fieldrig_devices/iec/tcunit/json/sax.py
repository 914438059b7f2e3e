"""The native functions behind FB_JsonSaxWriter."""

from collections.abc import Callable
from functools import partial
from typing import Any

from fieldrig_devices.iec.host import Results
from fieldrig_devices.iec.tcunit.json.iso import CLOCKS
from fieldrig_devices.iec.tcunit.json.texts import Given, limit, short, size_of
from fieldrig_devices.iec.tcunit.json.writer import Writer
from fieldrig_devices.iec.types import Value


class Writers:
    """The writers of one run, by the handles of their instances."""

    def __init__(self, given: Given) -> None:
        self._given = given
        self._writers: dict[int, Writer] = {}

    def functions(self) -> dict[str, Callable[..., Results]]:
        made: dict[str, Callable[..., Results]] = {
            "AddKey": lambda writer, name: _done(self.writer(writer).key, self._given.text(name)),
            "AddNull": lambda writer: _done(self.writer(writer).value, None),
            "AddString": lambda writer, address: _done(self.writer(writer).value, self._given.text(address)),
            "AddKeyNull": lambda writer, name: self._pair(writer, name, None),
            "AddKeyString": lambda writer, name, address: self._pair(writer, name, self._given.text(address)),
            "StartArray": lambda writer: _done(self.writer(writer).begin, is_array=True),
            "EndArray": lambda writer: _done(self.writer(writer).end, is_array=True),
            "StartObject": lambda writer: _done(self.writer(writer).begin, is_array=False),
            "EndObject": lambda writer: _done(self.writer(writer).end, is_array=False),
            "ResetDocument": lambda writer: _done(self.writer(writer).reset),
            "GetDocument": lambda writer: short(self.writer(writer).text),
            "GetDocumentLength": lambda writer: size_of(self.writer(writer).text),
            "CopyDocument": lambda writer, *into: self._given.copy(self.writer(writer).text, *into),
            "GetMaxDecimalPlaces": lambda writer: (self.writer(writer).places,),
            "SetMaxDecimalPlaces": lambda writer, places: limit(self.writer(writer), places),
        }
        for name in ("Bool", "Dint", "Lint", "Lreal", "Real", "Udint", "Ulint"):
            made[f"Add{name}"] = lambda writer, value: _done(self.writer(writer).value, value)
        for name in ("Bool", "Lreal", "Number"):
            made[f"AddKey{name}"] = self._pair
        for name, clock in CLOCKS.items():
            made[f"Add{name}"] = lambda writer, value, clock=clock: _done(self.writer(writer).value, clock.text(value))
            made[f"AddKey{name}"] = lambda writer, key, value, clock=clock: self._pair(writer, key, clock.text(value))
        for name in ("Array", "Object"):
            made[f"AddRaw{name}"] = lambda writer, address: _done(self.writer(writer).raw, self._given.text(address))
        for form in ("Base64", "HexBinary"):
            made[f"Add{form}"] = partial(self._add_bytes, form)
        return made

    def writer(self, handle: int) -> Writer:
        """Return the writer of the instance with this handle."""
        return self._writers.setdefault(handle, Writer())

    def _add_bytes(self, form: str, handle: int, address: int, size: int) -> Results:
        self.writer(handle).value(self._given.encoded(form, address, size))
        return ()

    def _pair(self, handle: int, name: int, value: Value | None) -> Results:
        writer = self.writer(handle)
        writer.key(self._given.text(name))
        writer.value(value)
        return ()


def _done(work: Callable[..., None], *given: Any, **chosen: bool) -> Results:
    work(*given, **chosen)
    return ()
