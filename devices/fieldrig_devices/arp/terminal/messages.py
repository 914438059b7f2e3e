"""The terminal's EEPROM: messages 1 to 500 of 16 characters, which survive power-off.

Source: manual 5.12 (MSG); digest I-25 (500 and not 200).  Characters are those of ISO 8859-1.
"""

from contextlib import suppress
from typing import Final

from fieldrig.storage.store import Store, StoreError

COUNT: Final = 500
LENGTH: Final = 16


class Messages:
    def __init__(self, store: Store) -> None:
        self._store = store
        self._ram = memoryview(b"")
        with suppress(StoreError):
            self._find_ram()

    def __getitem__(self, number: int) -> str:
        """The message, or an empty text if nothing was stored or it cannot be shown."""
        text = bytes(self._ram[self._span(number)]).rstrip(b"\x00").decode("latin-1")
        return text if text.isprintable() else ""

    def __setitem__(self, number: int, text: str) -> None:
        """Store a message.  Raises ValueError for an invalid message, and StoreError if the memory is not available."""
        if len(text) > LENGTH or not text.isprintable() or max(text, default="") > "\xff":
            raise ValueError(f"{text!r} is not a message; expected up to {LENGTH} characters of ISO 8859-1")
        self._find_ram()
        self._ram[self._span(number)] = text.encode("latin-1").ljust(LENGTH, b"\x00")

    def _find_ram(self) -> None:
        if not self._ram:
            self._ram = self._store.buffered_ram(COUNT * LENGTH)

    @staticmethod
    def _span(number: int) -> slice:
        return slice((number - 1) * LENGTH, number * LENGTH)
