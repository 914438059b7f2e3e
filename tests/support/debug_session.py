"""A session of `fieldrig debug` with a device in virtual time, which goes on while the debugger waits."""

from collections.abc import Callable, Iterator

from fieldrig_devices.languages.debugging.adapter import Ask
from fieldrig_devices.languages.debugging.debugger import Debugger
from fieldrig_devices.languages.debugging.travel import Travel

MOMENT_MS = 20


class DebugSession:
    """`ask` puts a question to the debugging service, and `run_ms` lets the device run."""

    def __init__(
        self,
        ask: Ask,
        run_ms: Callable[[int], object],
        limit_s: float | None = 5.0,
        travel: Travel | None = None,
    ) -> None:
        self.said: list[str] = []
        self._run_ms = run_ms
        self.interrupts_after: int | None = None
        """Number of moments after which the user presses Ctrl-C."""
        self.debugger = Debugger(ask, self.said.append, self._moments, limit_s, travel)

    def do(self, *lines: str) -> list[str]:
        """Return the output of the last command."""
        for line in lines:
            self.said.clear()
            self.debugger.do(line)
        return self.said

    def _moments(self, limit_s: float | None) -> Iterator[object]:
        count = 0
        while limit_s is None or count * MOMENT_MS < limit_s * 1_000:
            if count == self.interrupts_after:
                self.interrupts_after = None
                raise KeyboardInterrupt
            self._run_ms(MOMENT_MS)
            count += 1
            yield None
