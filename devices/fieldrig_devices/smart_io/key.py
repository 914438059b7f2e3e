"""A key: what its mode makes of pressing and releasing it (PAML-087 to PAML-092).

Source: the manual gives the names of the modes only.  So TOGGLE inverts its value with each press.  AUTOREPEAT has the
value true while the key is pressed, and after DELAY it is false for one PERIOD before each repetition, so that each
repetition is an event as a press is.  With the other reading of AUTOREPEAT, press and repetitions are pulses of one
PERIOD.  A program may write the value, which holds until the key changes it (G-06).
"""

from collections.abc import Callable

from fieldrig.clock import Alarm, Clock
from fieldrig_devices.pamring.frames import KeyMode


class Key:
    def __init__(
        self,
        clock: Clock,
        mode: KeyMode,
        gap_ns: int,
        delay_ns: int,
        repeat_ns: int,
        on_change: Callable[[], None],
        *,
        is_pulsed: bool = False,
    ) -> None:
        """`on_change` is called when the key has changed the value.

        `gap_ns` is how long the value is false before a repetition, or with `is_pulsed` how long it is true; without
        `repeat_ns` there is none.
        """
        self._clock, self._mode, self._on_change = clock, mode, on_change
        self._gap_ns = gap_ns
        self._delay_ns, self._repeat_ns = max(delay_ns, 2 * gap_ns), max(repeat_ns, 2 * gap_ns)
        self._repeats = mode is KeyMode.AUTOREPEAT and repeat_ns > 0
        self._is_pulsed = is_pulsed and mode is KeyMode.AUTOREPEAT
        self._timer = Alarm(self._clock)
        self.value = False

    def start(self, is_pressed: bool) -> None:
        """Begin with a key in this state; a key that is already pressed is no press."""
        self.value = is_pressed and self._mode is not KeyMode.TOGGLE and not self._is_pulsed

    def stop(self) -> None:
        self._timer.stop()

    def put(self, is_pressed: bool) -> None:
        """Take a change of the key."""
        self.stop()
        if self._mode is not KeyMode.TOGGLE:
            self._change(is_pressed)
        elif is_pressed:
            self._change(not self.value)
        if is_pressed and self._is_pulsed:
            self._pulse(self._delay_ns)
        elif is_pressed and self._repeats:
            self._repeat_at(self._clock.now_ns() + self._delay_ns)

    def write(self, value: bool) -> None:
        """Set the value, as a program does; it knows the value, so that this is no change for it."""
        self.value = value

    def _change(self, value: bool) -> None:
        if value is not self.value:
            self.value = value
            self._on_change()

    def _pulse(self, next_ns: int) -> None:
        """Begin a pulse; the next one follows after `next_ns` if the key repeats."""
        self._change(True)
        now_ns = self._clock.now_ns()
        self._timer.at(now_ns + self._gap_ns, lambda: self._end_pulse(now_ns + next_ns))

    def _end_pulse(self, next_ns: int) -> None:
        self._change(False)
        self._timer.at(next_ns, lambda: self._pulse(self._repeat_ns)) if self._repeats else None

    def _repeat_at(self, when_ns: int) -> None:
        self._timer.at(when_ns - self._gap_ns, self._on_gap)

    def _on_gap(self) -> None:
        self._change(False)
        self._timer.after(self._gap_ns, self._on_repeat)

    def _on_repeat(self) -> None:
        self._change(True)
        self._repeat_at(self._clock.now_ns() + self._repeat_ns)
