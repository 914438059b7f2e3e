"""COM1 of the controller: it looks for a modem, initialises it, and answers its calls.

Source: PacDrive manual 4494-4689 (digest PD-241 to PD-258).  The tables of the manual are in `states.py`.  The
manual gives the 10 s between searches; the other times are our choice.  A call begins with CONNECT, or 1 s after DCD
without it, and ends with DCD.  DTR goes off for 1 s to end a call, at a boot, and when the user of the port changes.
A call that the controller ends is hung up when its last frame has passed the line and the modems, after 10 s at most.
Left out: the serial protocol of EPAS-4, which is not public.
"""

import logging
from collections.abc import Callable
from typing import Final, Protocol

from fieldrig.clock import MS, Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.serial.end import OFF, LineEnd
from fieldrig_bus.serial.message import ControlLines, Format, ModemInputs, SerialMessage, inputs_from
from fieldrig_devices.max4.com1.initialisation import Initialisation
from fieldrig_devices.max4.com1.parameters import Com1Parameters
from fieldrig_devices.max4.com1.results import Result, ResultReader
from fieldrig_devices.max4.com1.states import (
    CHOSEN,
    NEXT,
    OFFLINE,
    ONLINE,
    RELEASED,
    RELEASED_TO,
    SEARCHING,
    TESTING,
    Com1State,
    Event,
    ModemState,
    User,
)
from fieldrig_devices.max4.configuration.tree import Parameter

log = logging.getLogger(__name__)

BAUD: Final = 38_400
CLEAR_NS: Final = 1 * S
LOOK_NS: Final = 1 * S
SEARCH_NS: Final = 10 * S
CONNECT_NS: Final = 1 * S
PASSED_NS: Final = 300 * MS
"""Time in which the modems have transmitted what the line has brought."""
LEAVE_NS: Final = 10 * S
FULL: Final = 1024
"""The number of bytes that wait for the line from which on a call should send no further data."""


class Call(Protocol):
    """The part of the controller that answers a call."""

    def received(self, data: bytes) -> None: ...

    def has_room(self) -> None:
        """Fewer than `FULL` bytes wait for the line again."""

    def ended(self) -> None:
        """The line is gone; nothing may be sent any more."""


Answer = Callable[[Callable[[bytes], None], Callable[[], None], Callable[[], int]], Call]
"""Makes the `Call` from functions that send bytes, hang up, and return the number of bytes that wait for the line."""


class Com1:
    """The port of one controller, without a line as well as with one."""

    def __init__(
        self, clock: Clock, link: Link[SerialMessage] | None, answer: Answer | None = None, baud: int | None = BAUD
    ) -> None:
        """Drop data of a call without `answer`.  `baud` None: bytes are handed to the line at once."""
        self._clock, self._answer = clock, answer
        self._format = None if baud is None else Format(baud)
        self._link = link
        self._line: LineEnd | None = None
        if link is not None:
            self._line = LineEnd(link, clock, self._format or Format(), baud is not None, FULL)
            self._line.on_room = self._on_room
        self._inputs = ModemInputs(cts=False, dsr=False, dcd=False, ri=False)
        self._reader = ResultReader()
        self._initialisation = Initialisation(clock, self._send, self._set_modem_state, self._on_initialised)
        self._timer = Alarm(self._clock)
        self._call_timer = Alarm(self._clock)
        self._hang_up_timer = Alarm(self._clock)
        self._next_search_ns = 0
        self._parameters: Com1Parameters | None = None
        self._user = User.EPAS_4
        self._call: Call | None = None
        self.state = Com1State.INIT
        self.modem_state = ModemState.INIT
        if link is not None:
            link.on_receive(self._on_message, ("data", "lines"))

    # ---- power and parameters

    def boot(self, parameters: Com1Parameters) -> None:
        """Begin with the parameters of a boot."""
        self._parameters = parameters
        if self._link is not None and self._format is not None:
            self._link.send(self._format)
        self._choose(User(int(parameters.user.value)))

    def end(self) -> None:
        """Power off, or the end before another boot: the line drops."""
        self._parameters = None
        self._release(Com1State.INIT)
        self.modem_state = ModemState.INIT

    def user_written(self, user: Parameter) -> None:
        """Act on Com1User if its value has changed (PD-255)."""
        parameters = self._parameters
        if parameters is None or parameters.user is not user:
            return
        if int(user.value) != self._user:
            self._choose(User(int(user.value)))

    @property
    def _is_looking(self) -> bool:
        """True if a modem is looked for: the project has a Modem object, and the user is Modem or Auto (PD-242)."""
        return self._user in CHOSEN and self._parameters is not None and self._parameters.modem is not None

    def _choose(self, user: User) -> None:
        self._user = user
        self.modem_state = ModemState.INIT
        if self._is_looking:
            self._release(Com1State.INIT)
            self._after(CLEAR_NS, self._on_cleared)
        else:
            self._release(RELEASED_TO[user])
            self._set_lines(is_on=user is not User.NONE)

    def _release(self, state: Com1State) -> None:
        """Stop all that goes on, and drop the lines."""
        self.state = state
        self._stop()
        self._hang_up_timer.stop()
        self._set_lines(is_on=False)

    def _stop(self) -> None:
        self._timer.stop()
        self._call_timer.stop()
        self._initialisation.cancel()
        if self._line is not None:
            self._line.purge()
        self._reader.clear()
        call, self._call = self._call, None
        if call is not None:
            call.ended()

    def _on_cleared(self) -> None:
        self._set_lines(is_on=True)
        self._happen(CHOSEN[self._user])

    # ---- the line

    def _set_lines(self, *, is_on: bool) -> None:
        if self._line is not None:
            self._line.set_lines(ControlLines() if is_on else OFF)

    def _send(self, data: bytes) -> None:
        if self._line is not None:
            self._line.send(data)

    def _on_message(self, message: SerialMessage) -> None:
        if type(message) is bytes:
            self._on_bytes(message)
        elif type(message) is ControlLines:
            self._on_inputs(inputs_from(message))

    def _on_inputs(self, inputs: ModemInputs) -> None:
        before, self._inputs = self._inputs, inputs
        if self._line is not None:
            self._line.hold(not inputs.cts)
        if inputs.dsr and not before.dsr:
            self._happen(Event.READY)
        elif before.dsr and not inputs.dsr:
            self._on_gone()
        if inputs.dcd and not before.dcd:
            self._await_connect()
        elif before.dcd and not inputs.dcd:
            self._call_timer.stop()
            self._happen(Event.CALL_ENDED)

    def _on_gone(self) -> None:
        if self.state in RELEASED and self._is_looking:
            self._set_modem_state(ModemState.NO_MODEM)
            self._search_later()
        self._happen(Event.GONE)

    def _on_bytes(self, data: bytes) -> None:
        if self.state in ONLINE:
            if self._call is not None:
                self._call.received(data)
            return
        while data:
            result, data = self._reader.feed(data)
            if result is Result.CONNECT and self.state in OFFLINE:
                self._happen(Event.CALL)
                if data and self._call is not None:
                    self._call.received(data)
                return
            if result is not None:
                self._initialisation.on_result(result)

    # ---- states

    def _happen(self, event: Event) -> None:
        state = NEXT.get((self.state, event))
        if state is None or not self._is_looking:
            return
        log.debug("COM1: %s, %s: %s", self.state.name, event.name, state.name)
        self._stop()
        self.state = state
        if state in SEARCHING:
            self._search()
        elif state in RELEASED and event is Event.NOTHING_FOUND:
            self._set_modem_state(ModemState.NO_MODEM)
            self._search_later()
        elif state in TESTING:
            self._test()
        elif state in OFFLINE:
            self._set_modem_state(ModemState.OFFLINE)
            self._await_connect()
        elif state in ONLINE:
            self._set_modem_state(ModemState.ONLINE)
            if self._answer is not None:
                self._call = self._answer(self._send_in_call, self._hang_up, self._waiting)

    def _search(self) -> None:
        self._set_modem_state(ModemState.INIT)
        self._next_search_ns = self._clock.now_ns() + SEARCH_NS
        if self._inputs.dsr:
            self._happen(Event.READY)
        else:
            self._after(LOOK_NS, lambda: self._happen(Event.NOTHING_FOUND))

    def _search_later(self) -> None:
        now_ns = self._clock.now_ns()
        delay_ns = self._next_search_ns - now_ns if self._next_search_ns > now_ns else SEARCH_NS
        self._after(delay_ns, lambda: self._happen(Event.SEARCH_DUE))

    def _test(self) -> None:
        modem = self._parameters.modem if self._parameters is not None else None
        assert modem is not None, "a modem is looked for only with a Modem object"
        self._set_modem_state(ModemState.INIT)
        self._initialisation.begin((str(modem.init_string.value), str(modem.exp_init_string.value)))

    def _set_modem_state(self, state: ModemState) -> None:
        self.modem_state = state

    def _on_initialised(self, is_accepted: bool) -> None:
        self._happen(Event.INITIALISED if is_accepted else Event.REFUSED)

    # ---- calls

    def _await_connect(self) -> None:
        """Take DCD for a call if no CONNECT follows."""
        if self.state in OFFLINE and self._inputs.dcd:
            self._call_timer.after(CONNECT_NS, lambda: self._happen(Event.CALL))

    def _send_in_call(self, data: bytes) -> None:
        if self.state in ONLINE:
            self._send(data)

    def _on_room(self, has_room: bool) -> None:
        if has_room and self._call is not None:
            self._call.has_room()

    def _waiting(self) -> int:
        return self._line.waiting if self._line is not None else 0

    def _hang_up(self) -> None:
        """End the call, once everything has been transmitted."""
        if self.state in ONLINE:
            self._drop_later(self._clock.now_ns() + LEAVE_NS)

    def _drop_later(self, limit_ns: int) -> None:
        sent_ns = self._line.sent_ns if self._line is not None else 0
        when_ns = min(max(sent_ns, self._clock.now_ns()) + PASSED_NS, limit_ns)
        self._hang_up_timer.at(when_ns, lambda: self._drop(limit_ns))

    def _drop(self, limit_ns: int) -> None:
        """Drop DTR, on which a modem ends its call, unless the modem has held the line in the meantime."""
        if self._waiting() and self._clock.now_ns() < limit_ns:
            self._drop_later(limit_ns)
        elif self.state in ONLINE:
            self._set_lines(is_on=False)
            self._hang_up_timer.after(CLEAR_NS, self._on_hung_up)

    def _on_hung_up(self) -> None:
        self._set_lines(is_on=True)
        self._happen(Event.CALL_ENDED)

    def _after(self, delay_ns: int, action: Callable[[], None]) -> None:
        self._timer.after(delay_ns, action)
