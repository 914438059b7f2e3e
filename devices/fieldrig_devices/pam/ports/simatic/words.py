"""The words of a Simatic DualPort by name: variables where the application declares them, FIFOs, flags of the start.

Source: sections 12.1 and 12.2 (PAMS-089, PAMS-095).  An entry of a FIFO is the byte address of a variable.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.pam.language.ports import PortPlan, PortVariable
from fieldrig_devices.pam.ports.panel import BEFORE_WATCH_DOG
from fieldrig_devices.pam.ports.simatic.cells import bit_place, item_place
from fieldrig_devices.pam.ports.words import PANEL, Piece

FLAGS: Final = ("PAM_READY", "DUALPORT_READY", "HOST_READY")
WHOLE: Final = 0xFFFF


class SimaticWords:
    """The map of one Simatic DualPort.  Implements `WordMap`."""

    def __init__(self, plan: PortPlan) -> None:
        self._words: dict[int, str] = {}
        """Variables and cells that are a whole word."""
        self._bits: dict[int, dict[int, str]] = {}
        """Flags by word, and by their mask."""
        self._kinds: dict[int, str] = {}
        self._entries: set[int] = set()
        self._ports(plan)
        for variable in plan.variables:
            for index in range(variable.number):
                place = item_place(variable, index)
                self._add(place.cell, place.mask, _item(variable, index), "variable")

    def _ports(self, plan: PortPlan) -> None:
        watch_dog = plan.numbers("WATCH_DOG")[0]
        self._add(watch_dog // 2, WHOLE, "WATCH_DOG", "watchdog")
        for at, name in enumerate(PANEL):
            self._add((watch_dog - BEFORE_WATCH_DOG) // 2 + at, WHOLE, f"panel {name}", "panel")
        for name in FLAGS:
            place = bit_place(*plan.numbers(name))
            self._add(place.cell, place.mask, name, "start")
        for fifo in ("FIFO_IN", "FIFO_OUT"):
            start, head, tail = (plan.numbers(f"{fifo}_{part}")[0] // 2 for part in ("START", "HEAD", "TAIL"))
            for word in range(start, head):
                self._add(word, WHOLE, f"{fifo} {word - start}", "FIFO")
                self._entries.add(word)
            self._add(head, WHOLE, f"{fifo}_HEAD", "FIFO")
            self._add(tail, WHOLE, f"{fifo}_TAIL", "FIFO")

    def _add(self, word: int, mask: int, name: str, kind: str) -> None:
        if mask == WHOLE:
            self._words.setdefault(word, name)
        else:
            self._bits.setdefault(word, {})[mask] = name
        self._kinds.setdefault(word, kind)

    def label(self, word: int) -> str:
        bits = self._bits.get(word)
        return self._words.get(word) or (" ".join(bits.values()) if bits else str(word))

    def piece(self, word: int, values: Sequence[int]) -> tuple[int, Piece]:
        value, kind = values[0], self._kinds.get(word, "words")
        bits = self._bits.get(word)
        if word not in self._words and bits is not None:
            told = (f"{name} {'on' if value & mask else 'off'}" for mask, name in sorted(bits.items()))
            return 1, Piece(kind, f"word {word}", " ".join(told))
        if word in self._entries:
            return 1, Piece(kind, self.label(word), self.label(value // 2) if value else "0")
        number = value - 0x10000 if kind == "variable" and value & 0x8000 else value
        return 1, Piece(
            kind, self._words.get(word, f"word {word}"), str(number) if kind != "words" else f"{value:04X}h"
        )


def _item(variable: PortVariable, index: int) -> str:
    return f"{variable.name}[{index + 1}]" if variable.is_multiple else variable.name
