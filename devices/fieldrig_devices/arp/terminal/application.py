"""The application of the terminal: its CANopen objects show, print and store messages, and report edits.

Source: manual 5.12; docs/devices/arp/arp-terminal.md.  An invalid command is refused: an SDO gets an abort, a PDO is
dropped.
"""

from collections import deque
from datetime import datetime
from functools import partial
from typing import Final

from fieldrig.link import Link
from fieldrig.storage.store import Store, StoreError
from fieldrig_devices.arp.terminal import objects
from fieldrig_devices.arp.terminal.editor import Editor
from fieldrig_devices.arp.terminal.messages import COUNT, LENGTH, Messages
from fieldrig_devices.arp.terminal.objects import Act, Print
from fieldrig_devices.arp.terminal.pattern import find
from fieldrig_devices.arp.terminal.screen import CELLS, Edit, Place, Screen, Text
from fieldrig_devices.arp.terminal.settings import TerminalSettings
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.node import CanopenNode
from fieldrig_devices.canopen.service import Reset, Service, State
from fieldrig_devices.canopen.variable import Variable

_KEPT: Final = 20  # number of lines
_END_OF_LINE: Final = b"\r\n"


class Printer:
    """The printer at the terminal's serial port: it prints one line for each message.

    Source: manual 5.12 (PRINT).  The format of date and time is ours.
    Left out: a printer that is busy or has no paper.  If `line` is None, nothing is
    connected; the last lines are kept all the same.
    """

    def __init__(self, line: Link[bytes] | None) -> None:
        self._line = line
        self.lines: deque[str] = deque(maxlen=_KEPT)

    def print(self, text: str) -> None:
        self.lines.append(text)
        if self._line is not None:
            self._line.send(text.encode("latin-1", "replace") + _END_OF_LINE)

    def print_time(self, now: datetime) -> None:
        self.print(f"{now:%d/%m/%Y}")
        self.print(f"{now:%H:%M:%S}")


_EDITS: Final[dict[Act, Edit]] = {Act.SHOW: "", Act.SHOW_VALUE: "", Act.EDIT: "E", Act.EDIT_WITH_PASSWORD: "P"}


class Application(Service):
    """The application of a `node` that has the objects of terminal.eds."""

    def __init__(
        self, node: CanopenNode, settings: TerminalSettings, store: Store, printer: Link[bytes] | None
    ) -> None:
        self._node, self._decimals = node, settings.decimals
        self.messages = Messages(store)
        self.screen = Screen(settings.decimals)
        self.editor = Editor(self.screen, settings.password, self._on_edited)
        self.printer = Printer(printer)
        self._edits = 0
        self._at(objects.SCREEN, 5).writer = self._on_screen
        self._at(objects.VALUE, 3).writer = self._on_value
        self._at(objects.PRINTER, 3).writer = self._on_print
        for number in range(1, COUNT + 1):
            variable = self._at(*objects.place_of_message(number))
            variable.reader = partial(self._read_message, number)
            variable.writer = partial(self._on_message, number)
        node.attach(self)

    def reset(self, scope: Reset) -> None:
        """Clear the screen when the terminal starts; messages and the printed lines are kept."""
        if scope is Reset.NODE:
            self.screen.clear()
            self.editor.follow()

    def enter(self, state: State) -> None:
        """Reset the edit, so that the TPDO 2 that is sent when the terminal starts does not repeat the last edit."""
        if state is State.OPERATIONAL:
            for subindex in (1, 2, 3, 4):
                self._at(objects.EDITED, subindex).put(0)

    def set_key(self, bit: int, is_down: bool) -> None:
        keys = self._at(objects.KEYS)
        keys.put(keys.number | 1 << bit if is_down else keys.number & ~(1 << bit))

    def is_lit(self, bit: int) -> bool:
        return bool(self._at(objects.LEDS).number >> bit & 1)

    def _at(self, index: int, subindex: int = 0) -> Variable:
        return self._node.dictionary.find(index, subindex)

    def _read_message(self, number: int) -> bytes:
        return self.messages[number].encode("latin-1")

    def _on_message(self, number: int, data: bytes) -> None:
        if len(data) > LENGTH:
            raise Abort(Code.LENGTH_TOO_HIGH)
        try:
            self.messages[number] = data.rstrip(b"\x00").decode("latin-1")
        except StoreError as cause:
            raise Abort(Code.HARDWARE) from cause
        except ValueError as cause:
            raise Abort(Code.INVALID_VALUE) from cause

    def _message(self, number: int) -> str:
        if not 1 <= number <= COUNT:
            raise Abort(Code.INVALID_VALUE)
        return self.messages[number]

    def _on_screen(self, data: bytes) -> None:
        line, column = (self._at(objects.SCREEN, subindex).number for subindex in (1, 2))
        act = data[0]
        if act == Act.CLEAR:
            self.screen.clear()
        elif act == Act.ERASE:
            self.screen.erase(Place(line, column))
        elif act in _EDITS:
            self.screen.show(Place(line, column), self._text(Act(act)))
        elif act != Act.NONE:
            raise Abort(Code.INVALID_VALUE)
        self.editor.follow()
        self._at(objects.SCREEN, 5).set(data)

    def _text(self, act: Act) -> Text:
        height, message = (self._at(objects.SCREEN, subindex).number for subindex in (3, 4))
        if height not in CELLS:
            raise Abort(Code.INVALID_VALUE)
        return Text(self._message(message), height, act is not Act.SHOW, _EDITS[act])

    def _on_value(self, data: bytes) -> None:
        line, column = (self._at(objects.VALUE, subindex).number for subindex in (1, 2))
        self.screen.set_value(Place(line, column), _signed(data))
        self._at(objects.VALUE, 3).set(data)

    def _on_print(self, data: bytes) -> None:
        message, act = self._at(objects.PRINTER, 2).number, data[0]
        if act > max(Print):
            raise Abort(Code.INVALID_VALUE)
        if act != Print.NONE and message == 0:
            self.printer.print_time(datetime.fromisoformat(str(self._node.points()["time"].read())))
        elif act != Print.NONE:
            self.printer.print(self._printed(self._message(message), Print(act)))
        self._at(objects.PRINTER, 3).set(data)

    def _printed(self, message: str, act: Print) -> str:
        field = find(message)
        if field is None or act is not Print.MESSAGE_WITH_VALUE:
            return message
        return field.put_into(message, field.show(_signed(self._at(objects.PRINTER, 1).data), self._decimals))

    def _on_edited(self, place: Place, raw: int) -> None:
        """Report an edit by TPDO 2, which is sent once, because all its objects change at the same instant."""
        self._edits = self._edits % 0xFF + 1
        for subindex, number in enumerate((*place, self._edits, raw), start=1):
            self._at(objects.EDITED, subindex).put(number)


def _signed(data: bytes) -> int:
    return int.from_bytes(data, "little", signed=True)
