"""The channels of the fast outputs, connected to the clock, the inputs and the wires.

A PTO channel sends the segments of its pulse train on the wire of its pulse output, and the level of its direction on
the other one (SCU-012).  A PWM channel sends its signal whenever frequency, duty or phase change.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Protocol

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.device import Point
from fieldrig.link import Link
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal
from fieldrig_devices.hmiscu.blocks.administrative import PTOGetDiag, PTOGetParam, PTOSetParam, PTOSimple
from fieldrig_devices.hmiscu.blocks.axis_block import REF_OF_CHANNEL_0, AxisBlock
from fieldrig_devices.hmiscu.blocks.motion import PTOMoveRelative, PTOMoveVelocity, PTOStop
from fieldrig_devices.hmiscu.blocks.pins import Block, BlockType
from fieldrig_devices.hmiscu.blocks.pwm_block import PWM
from fieldrig_devices.hmiscu.io import Terminals
from fieldrig_devices.hmiscu.models import DRIVE_READY, FAST_OUTPUTS
from fieldrig_devices.hmiscu.names import PWM_NAMES, SIMPLE
from fieldrig_devices.hmiscu.pto.channel import PtoChannel
from fieldrig_devices.hmiscu.pto.settings import PtoSettings
from fieldrig_devices.hmiscu.pwm.channel import PwmChannel, PwmPins
from fieldrig_devices.hmiscu.pwm.settings import PwmSettings
from fieldrig_devices.hmiscu.settings import HmiscuSettings
from fieldrig_devices.pulses.output import EdgePlayer

AXIS_BLOCKS: Final[Mapping[str, type[AxisBlock]]] = {
    "PTOMoveRelative": PTOMoveRelative,
    "PTOMoveVelocity": PTOMoveVelocity,
    "PTOStop": PTOStop,
    "PTOGetParam": PTOGetParam,
    "PTOSetParam": PTOSetParam,
    "PTOGetDiag": PTOGetDiag,
}


class Timed(Protocol):
    """A channel that does something by itself at an instant."""

    @property
    def next_ns(self) -> int: ...

    def advance(self, now_ns: int) -> None: ...


class Waker:
    """Advances one channel at its instants."""

    def __init__(self, clock: Clock, channel: Timed) -> None:
        self._clock, self._channel = clock, channel
        self._alarm = Alarm(clock)

    def set(self) -> None:
        """Wake the channel at its next instant; call this after everything that may have changed it."""
        self._alarm.at(self._channel.next_ns, self._on_time)

    def _on_time(self) -> None:
        self._channel.advance(self._clock.now_ns())
        self.set()


class Watched(Block):
    """A block after whose call the timers are set."""

    def __init__(self, inner: Block, then: "FastOutputs") -> None:
        self.type = inner.type
        self.inputs, self.outputs = inner.inputs, inner.outputs
        self._inner, self._then = inner, then

    def call(self, now_ns: int) -> None:
        self._inner.call(now_ns)
        self._then.after()


class FastOutputs:
    """The channels of one controller."""

    def __init__(
        self, clock: Clock, settings: HmiscuSettings, terminals: Terminals, wires: Link[Signal] | None
    ) -> None:
        self._clock, self._settings, self._terminals, self._wires = clock, settings, terminals, wires
        self._pto: PtoChannel | None = None
        self._pwm: dict[int, PwmChannel] = {}
        self._players: dict[str, EdgePlayer] = {}
        self._level: bool | None = None
        self._direction_wire = ""
        for number, channel in enumerate((settings.channel_0, settings.channel_1)):
            if isinstance(channel, PtoSettings):
                self._pto = self._make_pto(channel)
            elif isinstance(channel, PwmSettings):
                self._pwm[number] = PwmChannel(channel, self._send, name=settings.wire_of(FAST_OUTPUTS[number]))
        channels: list[Timed] = [*([] if self._pto is None else [self._pto]), *self._pwm.values()]
        self._wakers = [Waker(clock, channel) for channel in channels]
        self._aliases = _aliases(settings)

    def _make_pto(self, channel: PtoSettings) -> PtoChannel:
        pulse, direction = (self._settings.wire_of(output) for output in FAST_OUTPUTS)
        if channel.output_mode == "direction/pulse":
            pulse, direction = direction, pulse
        self._direction_wire = direction
        mast_ns = self._settings.mast.cycle_ms * MS
        return PtoChannel(channel, self._send_all, name=pulse, mast_ns=mast_ns, start_ns=self._clock.now_ns())

    def start(self) -> None:
        """Send what is on the outputs at power-on, and take the present inputs."""
        if self._pto is not None:
            self._send(self._pto.output.train)
        for channel in self._pwm.values():
            self._send(channel.signal)
        self.after()

    # ---- outputs

    def _send_all(self, signals: Sequence[PulseTrain]) -> None:
        for signal in signals:
            self._send(signal)

    def _send(self, signal: PulseTrain | Pwm) -> None:
        if self._pto is not None:
            self._send_direction()
        if not signal.name or self._wires is None:
            return
        if self._settings.fast_signals == "segments":
            self._wires.send(signal)
        else:
            player = self._players.get(signal.name)
            if player is None:
                player = self._players[signal.name] = EdgePlayer(self._clock, self._wires, signal.name)
            player.play(signal)

    def _send_direction(self) -> None:
        assert self._pto is not None
        level = self._pto.direction_level
        if level is not self._level:
            self._level = level
            if self._direction_wire and self._wires is not None:
                self._wires.send(Signal(self._direction_wire, level))

    def after(self) -> None:
        """Show the direction, and set the timers, after something may have changed a channel."""
        if self._pto is not None:
            self._send_direction()
        for waker in self._wakers:
            waker.set()

    # ---- inputs and the controller

    def on_input(self, terminal: str) -> None:
        """Take the level of an input that a channel may have."""
        now_ns, settings = self._clock.now_ns(), self._settings
        level = self._terminals.level(terminal) if terminal.startswith("DI") else False
        if self._pto is not None and terminal == DRIVE_READY:
            self._pto.put_drive_ready(now_ns, level)
        for number, channel in self._pwm.items():
            if terminal == settings.pwm_input("enable_0" if number == 0 else "enable_1"):
                channel.put_enable(now_ns, level)
            if terminal == settings.pwm_input("sync_0" if number == 0 else "sync_1"):
                channel.put_sync(now_ns, level)
        self.after()

    def shut_down(self) -> None:
        """Stop all moves and switch the PWM outputs off, because the controller has left RUN (SCU-099)."""
        now_ns = self._clock.now_ns()
        if self._pto is not None:
            self._pto.shutdown(now_ns)
        for channel in self._pwm.values():
            channel.set_pins(now_ns, PwmPins())
        self.after()

    def set_linked(self, is_linked: bool) -> None:
        """Break or restore the link to the firmware of the outputs (SCU-065)."""
        if self._pto is not None:
            self._pto.set_linked(self._clock.now_ns(), is_linked)
        self.after()

    def fail(self) -> None:
        """Take an internal error of the firmware (SCU-062)."""
        if self._pto is not None:
            self._pto.fail(self._clock.now_ns())
        self.after()

    def restart(self) -> None:
        """Begin again with the configured parameters, at a cold or warm start (SCU-056)."""
        if self._pto is not None:
            self._pto.restart(self._clock.now_ns())
        self.after()

    # ---- blocks

    @property
    def instances(self) -> dict[str, str]:
        """The types of the global variables of the channels by their names (SCU-010)."""
        first, second = self._settings.variables
        blocks = {} if first is None else {first: "PTOSimple" if self._pto is not None else "PWM"}
        return blocks | ({} if second is None else {second: "PWM"})

    def present_name(self, name: str) -> str:
        """Return the name of a point whose first part may be the usual name of a channel."""
        head, dot, rest = name.partition(".")
        return f"{self._aliases.get(head, head)}{dot}{rest}"

    def make(self, type_: BlockType, name: str) -> Block:
        """Return a new block.  Only the global variables of the channels have PTOSimple and PWM that do something."""
        if type_.name in AXIS_BLOCKS:
            axes = {} if self._pto is None else {REF_OF_CHANNEL_0: self._pto}
            return Watched(AXIS_BLOCKS[type_.name](axes), self)
        first, second = self._settings.variables
        if self._pto is not None and type_.name == "PTOSimple" and name == first:
            return Watched(PTOSimple(self._pto, REF_OF_CHANNEL_0), self)
        for number, own in enumerate((first, second)):
            if type_.name == "PWM" and name and name == own and number in self._pwm:
                return Watched(PWM(self._pwm[number]), self)
        return Idle(type_)

    # ---- points

    @property
    def axis(self) -> str:
        """The name of the axis of channel 0; empty if it has none."""
        return "" if self._pto is None else self._settings.variables[0] or SIMPLE

    def points(self) -> Iterator[tuple[str, Point]]:
        pto, name = self._pto, self.axis
        if pto is None:
            return
        yield f"{name}.State", Point(lambda: int(pto.state), about="state of the axis: 0 Standstill to 4 ErrorStop")
        yield f"{name}.ResetProblem", Point(lambda: pto.reset_problem, about="why the last ResetError had no effect")
        yield f"{name}.DirectionLevel", Point(lambda: pto.direction_level, about="level of the direction output")
        yield (
            f"{name}.Position",
            Point(
                lambda: _wrapped(pto.output.train.at(self._clock.now_ns())),
                unit="pulse",
                about="pulses forwards less backwards; from 2147483647 it goes on at -2147483648",
            ),
        )


def _wrapped(position: int) -> int:
    """Return the position in 32 bits, as each face shows it; an axis without a reference has no end."""
    return (position + (1 << 31)) % (1 << 32) - (1 << 31)


class Idle(Block):
    """An instance without a channel: nothing happens, and PTO_REF is the empty reference (SCU-063)."""

    def __init__(self, type_: BlockType) -> None:
        self.type = type_
        super().__init__()

    def call(self, now_ns: int) -> None:
        """Leave all outputs at 0."""


def _aliases(settings: HmiscuSettings) -> dict[str, str]:
    """Return the present names of the channels by their usual ones."""
    first, second = settings.variables
    usual = SIMPLE if isinstance(settings.channel_0, PtoSettings) else PWM_NAMES[0]
    return {name: own for name, own in ((usual, first), (PWM_NAMES[1], second)) if own is not None}
