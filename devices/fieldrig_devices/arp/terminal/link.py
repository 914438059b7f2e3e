"""The card's side of the operator terminal: MSG, TERM, PRINT, keys and LEDs, and the values on the screen.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16.  How it goes over the bus is ours (docs/arp-terminal.md):
messages by SDO, all else by PDO.  A terminal that doesn't answer, or is gone, is E06, and so is every instruction for
it.  When it is back it gets the screen that the program has made meanwhile; messages and lines to print are lost.
"""

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.arp.faults import CAN, Faults
from fieldrig_devices.arp.fixed import LIMIT
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.runtime.words import packed, unpacked
from fieldrig_devices.arp.terminal import objects, panel
from fieldrig_devices.arp.terminal.jobs import Clear, Erase, Job, Jobs, Line, Show, Store
from fieldrig_devices.arp.terminal.objects import Act, Edited, Print, PrintCommand, ScreenCommand, ValueAt
from fieldrig_devices.arp.terminal.screen import Place
from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.remote_node import RemoteNode

HEARTBEAT_MS: Final = 500
FRAMES_IN_PASS: Final = 8
"""PDOs to the terminal in one pass of the scheduler: it shares the bus with others."""
_MOST_IMAGES: Final = 32
_FURTHEST: Final = 255  # of the lines and columns that the bus carries; far off the screen
_KEYS: Final = slice(panel.FIRST_KEY_FLAG, panel.LAST_KEY_FLAG + 1)
_LEDS: Final = slice(panel.FIRST_LED_FLAG, panel.FIRST_KEY_FLAG)
_ACTS: Final = {"": Act.SHOW_VALUE, "E": Act.EDIT, "P": Act.EDIT_WITH_PASSWORD}


class TerminalLink:
    """Instructions only ask: they are carried out in their order, as fast as the terminal takes them."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame] | None,
        variables: list[int],
        flags: list[int],
        faults: Faults,
        set_variable: Callable[[int, int], None],
        readings: Readings | None = None,
    ) -> None:
        """`set_variable` gets the number of a V and the raw value that the operator has given it.

        Without `can` no terminal is configured.
        """
        self._clock, self._faults, self._set_variable = clock, faults, set_variable
        self._variables, self._flags = variables, flags
        self._follows = (readings or Readings()).terminal_value == "follows"
        self._shared = None if can is None else SharedLink(can)
        self._can: Link[CanFrame] | None = None
        self._node: RemoteNode | None = None
        self._node_id = 0
        self._is_lost = False
        self._jobs = Jobs()
        self._is_storing = False
        self._frames_left = 0
        self._stored: dict[int, str] = {}
        """Messages that this terminal has confirmed since it came."""
        self._picture: dict[Place, tuple[Show, str | None]] = {}
        """What it was told to show, and the message at that time, if the card knows it."""
        self._told: dict[Place, int | None] = {}
        """The value that stands at each place; None: not told yet.  Who was told last comes last."""
        self._told_leds: int | None = None
        self._images: deque[list[int]] = deque(maxlen=_MOST_IMAGES)
        self._keys = unpacked(0)

    def start(self, node_id: int | None) -> None:
        """Power-on.  None: no terminal is configured, F218 to F256 are the program's, and instructions are E06."""
        if self._shared is None or node_id is None:
            return
        self._node_id = node_id
        self._can = self._shared.share()
        known = {objects.KEYS_ID + node_id: self._on_keys, objects.EDITED_ID + node_id: self._on_edited}
        self._can.on_receive(
            lambda frame: known[frame.identifier](frame), [[key, EXTENDED_KEY | STANDARD_MASK] for key in known]
        )
        self._node = RemoteNode(
            self._clock, self._shared.share(), node_id, HEARTBEAT_MS, on_lost=self._on_lost, on_back=self._on_back
        )
        self._node.start()

    def refresh(self) -> None:
        """Every pass of the scheduler: keys to F225-F256, LEDs, instructions that wait, values that have changed."""
        if self._node is None:
            return
        self._refresh_keys()
        self._frames_left = FRAMES_IN_PASS
        if self._node.is_running:
            self._tell_leds()
            self._go_on()
            self._tell_values()

    def release(self) -> None:
        """The program was reset: what it asked for and was not carried out yet is forgotten, but for messages."""
        for job in self._jobs.take_all():
            if isinstance(job, Store):
                self._jobs.put(job)

    # The instructions.

    def store_message(self, number: int, text: str) -> None:
        self._ask(Store(number, text))

    def clear_screen(self) -> None:
        self._ask(Clear())

    def erase_text(self, line: int, column: int) -> None:
        self._ask(Erase(_place(line, column)))

    def show_text(self, shown: Shown) -> None:
        raw = None if shown.variable is None else self._variables[shown.variable]
        self._ask(Show(_place(shown.line, shown.column), shown, raw))

    def print_text(self, message: int, variable: int | None) -> None:
        self._ask(Line(message, None if variable is None else self._variables[variable]))

    def _ask(self, job: Job) -> None:
        is_kept = self._node is not None and not (self._is_lost and isinstance(job, Store | Line))
        if not is_kept or not self._jobs.put(job) or self._is_lost:
            self._faults.fail(CAN)

    # The terminal comes and goes.

    def _on_lost(self) -> None:
        self._is_lost, self._is_storing = True, False
        self._images.clear()
        self._keys = unpacked(0)  # no key stays pressed that nobody can let go
        for job in self._jobs.take_all():
            if not isinstance(job, Store | Line):
                self._jobs.put(job)
        self._faults.fail(CAN)

    def _on_back(self) -> None:
        """Whatever it shows now, it gets the program's screen, and then what the program has asked for since."""
        self._is_lost = self._is_storing = False
        self._stored.clear()
        self._told_leds = None
        waiting = self._jobs.take_all()
        for job in (Clear(), *(show for show, _ in self._picture.values()), *waiting):
            self._jobs.put(job)

    # From the terminal.

    def _on_keys(self, frame: CanFrame) -> None:
        image = int.from_bytes(frame.data, "little")
        if len(frame.data) == 4 and unpacked(image) != (self._images[-1] if self._images else self._keys):
            self._images.append(unpacked(image))

    def _refresh_keys(self) -> None:
        """One image in each pass, so that the program sees a key that was only touched; it can't write their flags."""
        if self._images:
            self._keys = self._images.popleft()
        if self._flags[_KEYS] != self._keys:
            self._flags[_KEYS] = self._keys

    def _on_edited(self, frame: CanFrame) -> None:
        edited = Edited.decode(frame.data)
        place = None if edited is None else Place(edited.line, edited.column)
        if edited is None or place not in self._picture or abs(edited.raw) > LIMIT:
            return
        shown = self._picture[place][0].shown
        if shown.variable is not None and shown.mode:
            self._told[place] = edited.raw
            self._set_variable(shown.variable, edited.raw)

    # To the terminal.

    def _send(self, first_id: int, data: bytes) -> None:
        assert self._can is not None
        self._frames_left -= 1
        self._can.send(CanFrame(first_id + self._node_id, data))

    def _tell_leds(self) -> None:
        leds = packed(self._flags[_LEDS])
        if leds != self._told_leds:
            self._told_leds = leds
            self._send(objects.LEDS_ID, bytes((leds,)))

    def _go_on(self) -> None:
        while not self._is_storing and self._frames_left > 0 and (job := self._jobs.first()) is not None:
            if isinstance(job, Store) and self._stored.get(job.number) != job.text:
                self._store(job)
                return
            self._jobs.drop_first()
            self._carry_out(job)

    def _store(self, job: Store) -> None:
        assert self._node is not None
        self._is_storing = True
        place = objects.place_of_message(job.number)
        self._node.sdo.download(*place, job.text.encode("latin-1", "replace"), partial(self._on_stored, job))

    def _on_stored(self, job: Store, abort: Abort | None) -> None:
        self._is_storing = False
        self._jobs.drop_first()
        if abort is None:
            self._stored[job.number] = job.text
        else:
            self._stored.pop(job.number, None)
            self._faults.fail(CAN)
        self._go_on()

    def _carry_out(self, job: Job) -> None:
        match job:
            case Show():
                self._show(job)
            case Clear():
                self._picture.clear()
                self._told.clear()
                self._send(objects.SCREEN_ID, ScreenCommand(Act.CLEAR).encode())
            case Erase(place):
                self._picture.pop(place, None)
                self._told.pop(place, None)
                self._send(objects.SCREEN_ID, ScreenCommand(Act.ERASE, place.line, place.column).encode())
            case Line(message, None):
                self._send(objects.PRINTER_ID, PrintCommand(Print.MESSAGE, message).encode())
            case Line(message, int(raw)):
                self._send(objects.PRINTER_ID, PrintCommand(Print.MESSAGE_WITH_VALUE, message, raw).encode())

    def _show(self, job: Show) -> None:
        """What stands there already is not told again, nor disturbed."""
        place, shown = job.place, job.shown
        message = self._stored.get(shown.message)
        present = self._picture.get(place)
        if present is None or (present[0].shown, present[1]) != (shown, message):
            self._picture.pop(place, None)
            act = Act.SHOW if shown.variable is None else _ACTS[shown.mode]
            self._send(objects.SCREEN_ID, ScreenCommand(act, *place, shown.height, shown.message).encode())
            self._told.pop(place, None)
        self._picture[place] = (job, message)
        if shown.variable is not None and (place not in self._told or not self._follows):
            self._tell_value(place, self._value(job))

    def _value(self, show: Show) -> int:
        assert show.shown.variable is not None
        return self._variables[show.shown.variable] if self._follows or show.raw is None else show.raw

    def _tell_value(self, place: Place, raw: int) -> None:
        self._told.pop(place, None)
        self._told[place] = raw
        self._send(objects.VALUE_ID, ValueAt(*place, raw).encode())

    def _tell_values(self) -> None:
        """As many as there is room for; who comes too late is first in the next pass."""
        for place, told in list(self._told.items()):
            if self._frames_left <= 0 or not self._follows:
                return
            raw = self._value(self._picture[place][0])
            if raw != told:
                self._tell_value(place, raw)


def _place(line: int, column: int) -> Place:
    return Place(min(line, _FURTHEST), min(column, _FURTHEST))
