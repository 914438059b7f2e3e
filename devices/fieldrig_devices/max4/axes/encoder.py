"""Logic and master encoders: positions that axes follow, updated in every cycle of the real-time process.

Source: PacDrive manual 3886-3905, 6967-6969 (digest PD-181, PD-182).  The program moves a logic encoder by setting its
position or its velocity.  A master encoder shows the position on a wire.  Their parameters are our choice.
"""

from fieldrig.clock import Clock, S
from fieldrig.device import Value
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.configuration.tree import Access, Object, Parameter, Type


class LogicEncoder:
    """An encoder that the program moves."""

    def __init__(self, node: Object) -> None:
        self.object = node
        self.position = 0.0
        self.velocity = 0.0
        """Velocity in units per second."""
        general = node.group("General")
        general.add(
            Parameter("Position", Type.LREAL, Access.INPUT, read=lambda: self.position, write=self._put_position)
        )
        general.add(
            Parameter("Velocity", Type.LREAL, Access.INPUT, read=lambda: self.velocity, write=self._put_velocity)
        )

    def step(self, cycle_ns: int) -> None:
        if self.velocity:
            self.position += self.velocity * cycle_ns / S

    def _put_position(self, value: Value) -> None:
        self.position = float(value)

    def _put_velocity(self, value: Value) -> None:
        self.velocity = float(value)


class MasterEncoder:
    """An encoder that shows a wire."""

    def __init__(self, clock: Clock, node: Object) -> None:
        self._clock = clock
        self.object = node
        self.position = 0.0
        self.velocity = 0.0
        """Position and velocity are the last samples of the real-time process; the parameters show the present ones."""
        self._signal: Signal | None = None
        general = node.group("General")
        general.add(Parameter("Position", Type.LREAL, read=lambda: self._present()[0]))
        general.add(Parameter("Velocity", Type.LREAL, read=lambda: self._present()[1]))

    def take(self, signal: Signal) -> None:
        self._signal = signal

    def step(self) -> None:
        self.position, self.velocity = self._present()

    def _present(self) -> tuple[float, float]:
        signal, now_ns = self._signal, self._clock.now_ns()
        return (0.0, 0.0) if signal is None else (float(signal.at(now_ns)), signal.speed_at(now_ns))
