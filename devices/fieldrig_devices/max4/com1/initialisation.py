"""Initialising a modem: InitString, and after its OK ExpInitString.

Source: PacDrive manual 4603-4650 (digest PD-247 to PD-252).  The manual gives no times.  Our choice: a
modem has 5 s for its answer, and 250 ms pass after each OK, because modems need a pause between commands.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

from fieldrig.clock import MS, Alarm, Clock, S
from fieldrig_devices.max4.com1.results import Result
from fieldrig_devices.max4.com1.states import ModemState

ANSWER_NS: Final = 5 * S
PAUSE_NS: Final = 250 * MS


class Step(NamedTuple):
    """The states to which the answer to a string leads."""

    ok: ModemState
    error: ModemState
    timeout: ModemState


STEPS: Final = (
    Step(ModemState.INIT_STRING_OK, ModemState.INIT_STRING_ERROR, ModemState.INIT_STRING_TIMEOUT),
    Step(ModemState.EXP_INIT_STRING_OK, ModemState.EXP_INIT_STRING_ERROR, ModemState.EXP_INIT_STRING_TIMEOUT),
)


class Initialisation:
    """One initialisation.  `on_state` is called with each state, `on_end` with true if both strings were accepted."""

    def __init__(
        self,
        clock: Clock,
        send: Callable[[bytes], None],
        on_state: Callable[[ModemState], None],
        on_end: Callable[[bool], None],
    ) -> None:
        self._clock, self._send, self._on_state, self._on_end = clock, send, on_state, on_end
        self._strings: Sequence[str] = ()
        self._place = 0
        self._timer = Alarm(self._clock)
        self._is_waiting = False

    def begin(self, strings: Sequence[str]) -> None:
        """Send InitString and ExpInitString."""
        self._strings, self._place = strings, 0
        self._next()

    def cancel(self) -> None:
        self._is_waiting = False
        self._timer.stop()

    def on_result(self, result: Result) -> None:
        """Take a result code; only OK and ERROR are answers."""
        if self._is_waiting and result is Result.OK:
            self._accept()
        elif self._is_waiting and result is Result.ERROR:
            self._give_up(STEPS[self._place].error)

    def _next(self) -> None:
        if self._place == len(STEPS):
            self._on_end(True)
            return
        self._is_waiting = True
        self._send(self._strings[self._place].encode("ascii", "replace") + b"\r")
        self._after(ANSWER_NS, partial(self._give_up, STEPS[self._place].timeout))

    def _accept(self) -> None:
        self.cancel()
        state = STEPS[self._place].ok
        self._place += 1
        self._after(PAUSE_NS, self._next)
        self._on_state(state)

    def _give_up(self, state: ModemState) -> None:
        self.cancel()
        self._on_state(state)
        self._on_end(False)

    def _after(self, delay_ns: int, action: Callable[[], None]) -> None:
        self._timer.after(delay_ns, action)
