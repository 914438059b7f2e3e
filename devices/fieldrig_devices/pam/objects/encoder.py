"""Encoders: registers of an ST1, read on request or by a sampler (section 2.7 of the language's digest)."""

from collections.abc import Callable
from typing import Any

from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.site import ApplicationNode, Site
from fieldrig_devices.pam.pipes.block import nearest, wrapped
from fieldrig_devices.pam.runtime.item import Pending, Value
from fieldrig_devices.pamring.registers import register_at, rolled


class Encoder(ObjectItem):
    """The position in user units; the roll-over of the register does not show (PAML-146)."""

    def __init__(self, declared: Declared, site: Site, node: ApplicationNode) -> None:
        super().__init__(declared.name)
        self._site, self._node = site, node
        self.address = declared.integer("ADDRESS")
        self.pulses_per_unit = declared.number("PULSES_PER_UNIT")
        self.position_period: float | None = declared.number("POSITION_PERIOD") or None
        self._raw: int | None = None
        self._count = 0
        """The register without its roll-over."""
        self._offset = 0.0
        self._speed = 0.0
        self._read_in = 0
        self._pending = 0
        self._samplers = 0

    # ---- readings

    @property
    def position(self) -> float:
        """The position at the last reading."""
        return wrapped(self._count / self.pulses_per_unit + self._offset, self.position_period)

    def _read(self, then: Callable[[], None], least_cycles: int = 0) -> None:
        """Read the register, and read again if a program has written another ADDRESS meanwhile."""
        address = self.address

        def take(raw: int | None) -> None:
            if self.address != address:
                self._read(then)
            else:
                self._on_answer(raw)
                then()

        self._site.read(self._node, address, take, least_cycles)

    def _on_answer(self, raw: int | None) -> None:
        self._pending -= 1
        if raw is not None:
            self._count += self._way(raw)
            self._raw = raw
        self._site.kernel.touched(self.name)

    def _way(self, raw: int) -> int:
        """Return the counts since the last reading, and note the speed."""
        if self._raw is None:
            self._read_in = self._site.cycle
            return raw
        register = register_at(self.address)
        way = raw - self._raw
        if register is not None and register.is_periodic:
            way = rolled(way, register.bits)
        cycles = self._site.cycle - self._read_in
        if cycles > 0:
            self._speed = way / self.pulses_per_unit / (cycles * self._site.cycle_s)
            self._read_in = self._site.cycle
        return way

    def sample(self) -> float:
        """Return the last reading, and ask for the next: a sampler keeps the encoder fresh (PAML-143)."""
        if self._pending == 0:
            self._pending += 1
            self._read(lambda: None)
        return self.position

    def begin_sampling(self) -> None:
        self._samplers += 1

    def end_sampling(self) -> None:
        self._samplers -= 1

    # ---- programs

    def value(self) -> Value | Pending:
        return self.ask_position()

    def ask_position(self) -> Value | Pending:
        return self._answered("position")

    ask_value = ask_position

    def ask_speed(self) -> Value | Pending:
        return self._answered("_speed")

    def ask_ready(self) -> bool:
        return self._pending == 0

    def _answered(self, attribute: str) -> Value | Pending:
        """Return a value at once while a sampler is active; otherwise read the register over the ring (PAML-144)."""
        if self._samplers:
            last: float = getattr(self, attribute)
            return last
        answer = Pending()

        def give() -> None:
            answer.value = getattr(self, attribute)

        self._pending += 1
        self._read(give, self._site.readings.read_cycles)
        return answer

    def do_position(self, position: float) -> None:
        """Call the present position by another value."""
        self._offset += nearest(float(position) - self.position, self.position_period)

    def set_parameter(self, name: str, value: Any) -> None:
        """Change ADDRESS, PULSES_PER_UNIT or POSITION_PERIOD; another register begins with its first reading."""
        if name == "ADDRESS":
            value, self._raw, self._count = int(value), None, 0
        super().set_parameter(name, value)
