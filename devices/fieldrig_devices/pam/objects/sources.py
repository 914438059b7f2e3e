"""Sources of pipes in programs: the generators and the sampler (sections 2.27 to 2.29 of the language's digest)."""

from collections.abc import Callable
from typing import Protocol

from fieldrig_devices.motion.profile import Limits
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.encoder import Encoder
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.parameters import AboveZero, OfBlock, PeriodOfBlock
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.pipes.block import effective_period_s
from fieldrig_devices.pam.pipes.pmp_generator import PmpGenerator, PmpLimits
from fieldrig_devices.pam.pipes.sampler import Sampler
from fieldrig_devices.pam.pipes.tmp_generator import TmpGenerator


class Source(Protocol):
    """A block that begins a pipe."""

    @property
    def outgoing_period(self) -> float | None: ...
    @property
    def ready(self) -> bool: ...
    def start(self, period_s: float) -> None: ...
    def stop(self) -> None: ...
    def step(self) -> float: ...


class SourceItem(ObjectItem):
    """The first block of a pipe; PERIOD is the effective one (PAML-413)."""

    block: Source

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared.name)
        self.site = site
        self.period = effective_period_s(declared.number("PERIOD"), site.kernel.thirds)

    def declare(self, declared: Declared) -> None:
        """Give the parameters the values of the declaration."""

    def begin(self, period_s: float) -> None:
        """The first pipe with this block is activated."""
        self.block.start(period_s)

    def end(self) -> None:
        self.block.stop()


class GeneratorItem(SourceItem):
    block: TmpGenerator | PmpGenerator
    acceleration = AboveZero()
    initial_position = OfBlock("initial_position")
    position_period = PeriodOfBlock("position_period")

    def _set_up(self, declared: Declared, block: TmpGenerator | PmpGenerator) -> None:
        self.block = block
        readings = self.site.readings
        block.takes_shorter_way = readings.takes_shorter_way
        block.run_is_ready_at_speed = readings.run_is_ready_at_speed
        if declared.word("ANTI_DELAY", "YES") == "YES":
            block.lead_s = readings.set_point_delay_periods * self.period

    def do(self, function: str, arguments: object = ()) -> None:
        super().do(function, arguments)  # type: ignore[arg-type]
        self.site.changes += 1
        self.site.kernel.touched(self.name)

    def ask_ready(self) -> bool:
        return self.block.ready

    def ask_position(self) -> float:
        return self.block.position

    def ask_speed(self) -> float:
        return self.block.speed

    def ask_acceleration(self) -> float:
        return self.block.acceleration

    def do_position(self, position: float) -> None:
        self.block.set_position(float(position))


class TmpItem(GeneratorItem):
    """Changed speeds and accelerations work from the next motion on (PAML-632)."""

    block: TmpGenerator
    travel_speed = AboveZero()
    deceleration = AboveZero()

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.declare(declared)
        generator = TmpGenerator(self._limits(), declared.number("INITIAL_POSITION"), _period(declared))
        self._set_up(declared, generator)

    def declare(self, declared: Declared) -> None:
        self.travel_speed = declared.number("TRAVEL_SPEED")
        self.acceleration = declared.number("ACCELERATION")
        self.deceleration = declared.number("DECELERATION", self.acceleration)

    def _limits(self) -> Limits:
        return Limits(self.travel_speed, self.acceleration, self.deceleration)

    def do_absolute_move(self, position: float) -> None:
        self.block.limits = self._limits()
        self.block.absolute_move(float(position))

    def do_relative_move(self, distance: float) -> None:
        self.block.limits = self._limits()
        self.block.relative_move(float(distance))

    def do_run(self, speed: float) -> None:
        self.block.limits = self._limits()
        self.block.run(float(speed))


class PmpItem(GeneratorItem):
    block: PmpGenerator
    first_travel_speed = AboveZero()
    last_travel_speed = AboveZero()
    jerk = AboveZero()

    def __init__(self, declared: Declared, site: Site) -> None:
        super().__init__(declared, site)
        self.declare(declared)
        generator = PmpGenerator(self._limits(), declared.number("INITIAL_POSITION"), _period(declared))
        generator.supersedes = site.readings.pmp_supersedes
        self._set_up(declared, generator)

    def declare(self, declared: Declared) -> None:
        self.first_travel_speed = declared.number("FIRST_TRAVEL_SPEED")
        self.last_travel_speed = declared.number("LAST_TRAVEL_SPEED")
        self.acceleration, self.jerk = declared.number("ACCELERATION"), declared.number("JERK")

    def _limits(self) -> PmpLimits:
        return PmpLimits(self.first_travel_speed, self.last_travel_speed, self.acceleration, self.jerk)

    def do_absolute_move(self, first: float, last: float | None = None) -> None:
        self.block.limits = self._limits()
        self.block.absolute_move(float(first), last)

    def do_relative_move(self, first: float, last: float | None = None) -> None:
        self.block.limits = self._limits()
        self.block.relative_move(float(first), last)

    def do_run(self, speed: float) -> None:
        self.block.limits = self._limits()
        self.block.run(float(speed))


class SamplerItem(SourceItem):
    """A sampler, which reads an encoder over the ring in each period, or the set position of an axis (PAML-620)."""

    block: Sampler

    def __init__(
        self, declared: Declared, site: Site, read: Callable[[], float], source: Encoder | None, period: float | None
    ) -> None:
        super().__init__(declared, site)
        self._encoder = source
        self.block = Sampler(read, is_speed=declared.word("MODE") == "SPEED")
        self.block.source_period = period

    def begin(self, period_s: float) -> None:
        if self._encoder is not None:
            self.block.source_period = self._encoder.position_period
            self._encoder.begin_sampling()
        super().begin(period_s)

    def end(self) -> None:
        super().end()
        if self._encoder is not None:
            self._encoder.end_sampling()

    def ask_value(self) -> float:
        return self.block.value


def _period(declared: Declared) -> float | None:
    return declared.number("POSITION_PERIOD") or None
