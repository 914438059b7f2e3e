"""Logic and master encoders: positions that axes follow, seen to in every cycle of the real-time process.

Source: PacDrive manual 3886-3905, 6967-6969 (digest PD-181, PD-182).  A logic encoder is moved by the program: it is
put somewhere, or runs with a velocity.  A master encoder counts a wire.  Their parameters are our choice.
"""

from fieldrig.clock import Clock, S
from fieldrig.device import Value
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.configuration.tree import Kind, Object, Parameter, Type


class LogicEncoder:
    def __init__(self, one: Object) -> None:
        self.object = one
        self.position = 0.0
        self.velocity = 0.0
        """Units per second."""
        general = one.group("General")
        general.add(Parameter("Position", Type.LREAL, Kind.INPUT, read=lambda: self.position, write=self._put_position))
        general.add(Parameter("Velocity", Type.LREAL, Kind.INPUT, read=lambda: self.velocity, write=self._put_velocity))

    def step(self, cycle_ns: int) -> None:
        if self.velocity:
            self.position += self.velocity * cycle_ns / S

    def _put_position(self, value: Value) -> None:
        self.position = float(value)

    def _put_velocity(self, value: Value) -> None:
        self.velocity = float(value)


class MasterEncoder:
    def __init__(self, clock: Clock, one: Object) -> None:
        self._clock = clock
        self.object = one
        self.position = 0.0
        self.velocity = 0.0
        """What the real-time process sampled last; the parameters are where the encoder is when they are read."""
        self._signal: Signal | None = None
        general = one.group("General")
        general.add(Parameter("Position", Type.LREAL, read=lambda: self._present()[0]))
        general.add(Parameter("Velocity", Type.LREAL, read=lambda: self._present()[1]))

    def take(self, signal: Signal) -> None:
        self._signal = signal

    def step(self) -> None:
        self.position, self.velocity = self._present()

    def _present(self) -> tuple[float, float]:
        signal, now_ns = self._signal, self._clock.now_ns()
        return (0.0, 0.0) if signal is None else (float(signal.at(now_ns)), signal.speed_at(now_ns))
