"""The phaser: y = (x + PHASE) modulo VALUE_PERIOD, with a stand-by value while it is stopped (PAML-580 to PAML-590)."""

from typing import Literal

from fieldrig_devices.pam.pipes.block import Block, Slewed, nearest, wrapped

PhaserState = Literal["started", "stopping", "stopped", "starting"]


class Phaser(Block):
    """A phaser; `phase_slope` is in units a second; None is MAX."""

    def __init__(self, phase: float, phase_slope: float | None, standby_value: float, value_period: float) -> None:
        super().__init__()
        self.phase = Slewed(phase, phase_slope)
        self.value_period = value_period
        self._standby_value = standby_value
        self.state: PhaserState = "started"
        self._computed: float | None = None

    @property
    def ready(self) -> bool:
        return self.state in ("started", "stopped") and self.phase.is_there

    @property
    def standby_value(self) -> float:
        return self._standby_value

    @standby_value.setter
    def standby_value(self, value: float) -> None:
        """The value that leaves the block while it is stopped, reduced to the period in an active block (PAML-588)."""
        self._standby_value = wrapped(value, self.value_period) if self.is_active else value
        if self.is_active and self.state in ("stopped", "starting"):
            self.value = self._standby_value

    is_at_rest = ready

    @property
    def outgoing_period(self) -> float | None:
        return self.value_period

    def set_phase(self, phase: float) -> None:
        """Change the phase: by its slope in a started block, else at once (PAML-584 to PAML-586).

        A step of the phase in a block that waits to start is no crossing of the stand-by value.
        """
        is_slewed = self.is_active and self.state in ("started", "stopping")
        self.phase.set(phase, at_once=not is_slewed)
        if not is_slewed:
            self._computed = None

    def command_start(self) -> None:
        if not self.is_active:
            self.state = "started"
        elif self.state in ("stopped", "starting"):
            self.state = "starting"
        else:
            self.state = "started"

    def command_stop(self) -> None:
        if not self.is_active:
            self.state = "stopped"
        elif self.state in ("started", "stopping"):
            self.phase.finish()
            self.state = "stopping"
        else:
            self.state = "stopped"

    def start(self, period_s: float) -> None:
        super().start(period_s)
        self._standby_value = wrapped(self._standby_value, self.value_period)
        self._computed = None

    def stop(self) -> None:
        super().stop()
        self.phase.finish()
        self.state = {"stopping": "stopped", "starting": "started"}.get(self.state, self.state)  # type: ignore[assignment]

    def transform(self, value: float) -> float:
        phase = self.phase
        shift = phase.value if phase.is_there else phase.step(self.period_s)
        last, self._computed = self._computed, wrapped(value + shift, self.value_period)
        if self.state == "started":
            return self._computed
        if self.state != "stopped" and last is not None and self._crosses(last, self._computed):
            self.state = "stopped" if self.state == "stopping" else "started"
        return self._computed if self.state in ("started", "stopping") else self._standby_value

    def _crosses(self, last: float, value: float) -> bool:
        """True if the way from one value to the next, the shorter one around the period, meets the stand-by value.

        A value that begins at the stand-by value meets it.
        """
        step = nearest(value - last, self.value_period)
        ahead = wrapped(self._standby_value - last, self.value_period)
        if step < 0:
            ahead = wrapped(last - self._standby_value, self.value_period)
        return ahead <= abs(step)
