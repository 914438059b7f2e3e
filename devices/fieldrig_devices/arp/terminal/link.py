"""The card's side of the operator terminal: MSG, TERM, PRINT, keys and LEDs, and the values on the screen.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16.  The transfer over the bus is ours
(docs/devices/arp/arp-terminal.md): messages by SDO, everything else by PDO.  A terminal that does not answer or is lost
causes E06, and so does every instruction for it.  When it is back, it receives the current screen of the program;
messages and lines to print are lost.
"""

from collections.abc import Callable
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import STANDARD_MASK, CanFrame
from fieldrig_bus.can.shared import SharedLink
from fieldrig_devices.arp.card_errors import CAN, CardErrors
from fieldrig_devices.arp.fixed import LIMIT
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import Shown
from fieldrig_devices.arp.runtime.words import packed
from fieldrig_devices.arp.terminal import objects, panel
from fieldrig_devices.arp.terminal.jobs import Clear, Erase, Job, Jobs, Line, Show, Store
from fieldrig_devices.arp.terminal.key_flags import KeyFlags
from fieldrig_devices.arp.terminal.messages import LENGTH
from fieldrig_devices.arp.terminal.objects import Edited, Print, PrintCommand
from fieldrig_devices.arp.terminal.picture import Picture
from fieldrig_devices.arp.terminal.screen import Place
from fieldrig_devices.canopen.abort import Abort
from fieldrig_devices.canopen.cob_id import EXTENDED_KEY
from fieldrig_devices.canopen.managed_slave import ManagedSlave

HEARTBEAT_MS: Final = 500
FRAMES_IN_PASS: Final = 8
"""PDOs to the terminal in one pass of the scheduler, plus one or two, since other nodes share the bus."""
_FURTHEST: Final = 255  # limit of lines and columns on the bus, far off the screen
_LEDS: Final = slice(panel.FIRST_LED_FLAG, panel.FIRST_KEY_FLAG)


class TerminalLink:
    """Carries out instructions in their order, as fast as the terminal accepts them."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame] | None,
        variables: list[int],
        flags: list[int],
        errors: CardErrors,
        set_variable: Callable[[int, int], None],
        readings: Readings | None = None,
    ) -> None:
        """`set_variable` is called with the number of a V and the raw value from the operator.

        Without `can`, no terminal is configured.
        """
        self._clock, self._errors, self._set_variable = clock, errors, set_variable
        self._variables, self._flags = variables, flags
        self._shared = None if can is None else SharedLink(can)
        self._can: Link[CanFrame] | None = None
        self._node: ManagedSlave | None = None
        self._is_lost = False
        self._jobs = Jobs()
        self._is_storing = False
        self._frames_left = 0
        self._stored: dict[int, str] = {}
        """Messages that the terminal has confirmed since it was found."""
        self._picture = Picture(variables, (readings or Readings()).terminal_value == "follows", self._send)
        self._keys = KeyFlags(flags)
        self._sent_leds: int | None = None
        self._edit_counter = 0

    def start(self, node_id: int | None) -> None:
        """Start at power-on.

        If `node_id` is None, no terminal is configured: F218 to F256 belong to the program, and instructions cause E06.
        """
        if self._shared is None or node_id is None:
            return
        self._can = self._shared.share()
        known = {objects.KEYS_ID + node_id: self._keys.take, objects.EDITED_ID + node_id: self._on_edited}
        self._can.on_receive(
            lambda frame: known[frame.identifier](frame.data), [[key, EXTENDED_KEY | STANDARD_MASK] for key in known]
        )
        self._node = ManagedSlave(
            self._clock, self._shared.share(), node_id, HEARTBEAT_MS, on_lost=self._on_lost, on_back=self._on_back
        )
        self._node.start()

    def refresh(self) -> None:
        """Update keys (F225-F256), LEDs and changed values, and send waiting instructions; call it in each scheduler
        pass."""
        if self._node is None:
            return
        self._keys.refresh()
        self._frames_left = FRAMES_IN_PASS
        if self._node.is_running:
            self._send_leds()
            self._go_on()
            for place, raw in self._picture.next_values():
                if self._frames_left > 0:
                    self._picture.send_value(place, raw)

    def release(self) -> None:
        """Discard waiting instructions apart from messages, because the program was reset."""
        self._keep(lambda job: isinstance(job, Store))

    # The instructions.

    def store_message(self, number: int, text: str) -> None:
        self._ask(Store(number, text[:LENGTH]))  # digest I-26

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
            self._errors.fail(CAN)

    def _keep(self, is_kept: Callable[[Job], bool]) -> None:
        for job in filter(is_kept, self._jobs.take_all()):
            self._jobs.put(job)

    # The terminal is lost and found.

    def _on_lost(self) -> None:
        self._is_lost, self._is_storing = True, False
        self._keys.let_go()
        self._keep(lambda job: not isinstance(job, Store | Line))
        self._errors.fail(CAN)

    def _on_back(self) -> None:
        """Draw the program's screen again, whatever the terminal shows, and then carry out later instructions."""
        self._is_lost = False
        self._stored.clear()
        self._sent_leds = None
        for job in (*self._picture.redrawn(), *self._jobs.take_all()):
            self._jobs.put(job)

    # From the terminal.

    def _on_edited(self, data: bytes) -> None:
        """Take an edit.

        Counter 0 means that the terminal has started; an unchanged counter, that the PDO was repeated.
        """
        edited = Edited.decode(data)
        if edited is None or edited.counter == self._edit_counter:
            return
        self._edit_counter = edited.counter
        if edited.counter != 0 and abs(edited.raw) <= LIMIT:
            variable = self._picture.edited(Place(edited.line, edited.column), edited.raw)
            if variable is not None:
                self._set_variable(variable, edited.raw)

    # To the terminal.

    def _send(self, first_id: int, data: bytes) -> None:
        assert self._can is not None
        assert self._node is not None
        self._frames_left -= 1
        self._can.send(CanFrame(first_id + self._node.node_id, data))

    def _send_leds(self) -> None:
        leds = packed(self._flags[_LEDS])
        if leds != self._sent_leds:
            self._sent_leds = leds
            self._send(objects.LEDS_ID, bytes((leds,)))

    def _go_on(self) -> None:
        while not self._is_storing and self._frames_left > 0 and (job := self._jobs.first()) is not None:
            if isinstance(job, Store) and self._stored.get(job.number) != job.text:
                self._store(job)
            else:
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
        self._stored.pop(job.number, None)
        if abort is None:
            self._stored[job.number] = job.text
        else:
            self._errors.fail(CAN)
        self._go_on()

    def _carry_out(self, job: Job) -> None:
        match job:
            case Clear() | Erase():
                self._picture.carry_out(job, None)
            case Show():
                self._picture.carry_out(job, self._stored.get(job.shown.message))
            case Line(message, None):
                self._send(objects.PRINTER_ID, PrintCommand(Print.MESSAGE, message).encode())
            case Line(message, int(raw)):
                self._send(objects.PRINTER_ID, PrintCommand(Print.MESSAGE_WITH_VALUE, message, raw).encode())


def _place(line: int, column: int) -> Place:
    return Place(min(line, _FURTHEST), min(column, _FURTHEST))
