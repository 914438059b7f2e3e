"""The I/O boards of an ST1: LPO with IN 0 and 1, OIO with IN 16 to 31 and OUT 8 to 15 (PAMS-110).

The PAM configures inputs and outputs one by one; outputs without a configuration have the levels that CACOUT gives.
Levels are electrical: true is 24 V.  Time stamps say when the level of an input changed.  By a setting only IN 16 has
them, and the other inputs have the age 0 (G-47).  The inputs of a board that is missing read noise, so that their
reports flood the PAM (11928).
"""

from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS, NEVER_NS, US, Alarm, Clock
from fieldrig_devices.pamring.frames import InputChanged, InputItem, OutputItem
from fieldrig_devices.st1.addresses import INPUT_ADDRESSES, OUTPUT_ADDRESSES
from fieldrig_devices.st1.readings import St1Readings
from fieldrig_devices.st1.sampled_input import SampledInput
from fieldrig_devices.st1.settings import OUTPUTS

OLDEST_US: Final = 0xFFFF_FFFF
"""Largest age that a report can carry."""
STAMPED: Final = 16
"""The input with a time stamp."""


class Input:
    """An input that the PAM has configured."""

    def __init__(self, item: InputItem, now_ns: int, level: bool, readings: St1Readings, *, is_there: bool) -> None:
        self.item, self.is_there = item, is_there
        self.period_ns = item.period_ms * MS
        self.sampled = SampledInput(now_ns, level, self.period_ns, item.debounce)
        self.noise_ns = NEVER_NS if is_there else now_ns + self.period_ns
        self.is_stamped = readings.time_stamps == "all" or INPUT_ADDRESSES[item.address] == STAMPED

    @property
    def next_ns(self) -> int:
        return min(self.sampled.next_ns, self.noise_ns)

    def advance(self, now_ns: int) -> bool:
        """Take the samples that are due; True if the level has changed."""
        if now_ns >= self.noise_ns:
            self.noise_ns += self.period_ns
            self.sampled.level = not self.sampled.level
            return True
        return self.sampled.advance(now_ns)

    def report(self, now_ns: int) -> InputChanged:
        age_us = (now_ns - self.sampled.changed_ns) // US if self.is_stamped else 0
        return InputChanged(self.item.item, int(self.sampled.level), min(age_us, OLDEST_US))


class Boards:
    def __init__(
        self,
        clock: Clock,
        cacout: int,
        readings: St1Readings,
        *,
        has_oio: bool,
        send: Callable[[InputChanged], None],
        drive: Callable[[int, bool], None],
    ) -> None:
        """`drive` is called with the number of an output and its level."""
        self._clock, self._has_oio, self._send, self._drive = clock, has_oio, send, drive
        self._readings = readings
        self.levels: dict[int, bool] = {}
        """Levels at the inputs, by number; those that nothing drives are low."""
        self.outputs = {number: not cacout >> (number - 8) & 1 for number in OUTPUTS}
        """Levels of the outputs, by number."""
        self._inactive = dict(self.outputs)
        self._input_items: dict[int, InputItem] = {}
        self._output_items: dict[int, OutputItem] = {}
        self._running: dict[int, list[Input]] = {}
        self._timer = Alarm(self._clock)

    def start(self) -> None:
        for number, level in self.outputs.items() if self._has_oio else ():
            self._drive(number, level)

    # ---- configuration

    def forget(self) -> None:
        """Forget all items; the outputs are inactive, with the levels of CACOUT."""
        self._input_items.clear()
        self._output_items.clear()
        self._running.clear()
        self._wait()
        for number, level in self._inactive.items():
            self._put_out(number, level)

    def accept_input(self, item: InputItem) -> bool:
        if item.bits != 1 or item.address not in INPUT_ADDRESSES or item.period_ms < 1 or item.debounce < 1:
            return False
        self._input_items[item.item] = item
        return True

    def accept_output(self, item: OutputItem) -> bool:
        if item.bits != 1 or item.address not in OUTPUT_ADDRESSES:
            return False
        self._output_items[item.item] = item
        self._put_out(OUTPUT_ADDRESSES[item.address], not item.is_active_high)
        return True

    def run(self) -> None:
        """Sample the inputs from now on, and report each of them."""
        now_ns = self._clock.now_ns()
        self._running.clear()
        for item in self._input_items.values():
            number = INPUT_ADDRESSES[item.address]
            is_there = self._has_oio or number < STAMPED
            running = Input(item, now_ns, self.levels.get(number, False), self._readings, is_there=is_there)
            self._running.setdefault(number, []).append(running)
            self._send(running.report(now_ns))
        self._wait()

    # ---- work

    def put(self, number: int, level: bool) -> None:
        """Take the level of an input."""
        if self.levels.get(number, False) is level:
            return
        self.levels[number] = level
        for running in self._running.get(number, ()):
            if running.is_there:
                running.sampled.put(self._clock.now_ns(), level)
        self._wait()

    def set_output(self, item: int, level: bool) -> bool:
        """Drive an output; False if there is no such item."""
        output = self._output_items.get(item)
        if output is not None:
            self._put_out(OUTPUT_ADDRESSES[output.address], level)
        return output is not None

    def _put_out(self, number: int, level: bool) -> None:
        if self.outputs[number] is not level:
            self.outputs[number] = level
            if self._has_oio:
                self._drive(number, level)

    def _on_timer(self) -> None:
        now_ns = self._clock.now_ns()
        for inputs in self._running.values():
            for running in inputs:
                if running.next_ns <= now_ns and running.advance(now_ns):
                    self._send(running.report(now_ns))
        self._wait()

    def _wait(self) -> None:
        when_ns = min((one.next_ns for inputs in self._running.values() for one in inputs), default=NEVER_NS)
        self._timer.at(when_ns, self._on_timer)
