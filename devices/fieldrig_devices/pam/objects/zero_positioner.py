"""Zero positioners: up to three phases that find the zero of an axis (section 2.10 of the language's digest)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from fieldrig_devices.motion.profile import Limits, Profile, change_speed
from fieldrig_devices.pam.objects.axis import Axis
from fieldrig_devices.pam.objects.declared import Declared
from fieldrig_devices.pam.objects.inputs import BinaryInput
from fieldrig_devices.pam.objects.object_item import ObjectItem
from fieldrig_devices.pam.objects.site import Site
from fieldrig_devices.pam.pipes.block import nearest
from fieldrig_devices.pamring.registers import Parameter, Primary, parameter_address

MOST_FINE: Final = 6
"""Zero positioners of a PAM in the fine phase at once (PAML-207)."""
MOTOR_TURN: Final = 1 << 32
"""Resolver units in a turn of the motor (PAML-045)."""
COUNTS_PER_TURN: Final = 1 << 16
"""Counts of the main resolver's register (Table 2-2, E-24)."""


class FinePhases:
    """The places in the fine phase; a zero positioner that finds none free waits in line."""

    def __init__(self) -> None:
        self._running = 0
        self._waiting: list[Callable[[], None]] = []

    def enter(self, begin: Callable[[], None]) -> None:
        if self._running < MOST_FINE:
            self._running += 1
            begin()
        else:
            self._waiting.append(begin)

    def leave(self, begin: Callable[[], None]) -> None:
        """Leave the phase, or the line in front of it."""
        if begin in self._waiting:
            self._waiting.remove(begin)
            return
        self._running -= 1
        if self._waiting:
            self.enter(self._waiting.pop(0))


@dataclass(slots=True)
class Search:
    """A phase that looks for an edge of the sensor."""

    speed: float | None
    """The sign is the direction; None is CURRENT."""
    is_rising: bool
    move: float | None
    """The distance from the edge; None only stops."""


class ZeroPositioner(ObjectItem):
    def __init__(
        self, declared: Declared, site: Site, axis: Axis, sensor: BinaryInput | None, fine_phases: FinePhases
    ) -> None:
        super().__init__(declared.name)
        self._site, self._axis, self._fine_phases = site, axis, fine_phases
        self._searches: dict[str, Search] = {}
        for phase in ("coarse", "fine"):
            name = phase.upper()
            if f"{name}_EDGE" in declared and sensor is not None:
                speed, move = declared.optional(f"{name}_SPEED"), declared.optional(f"{name}_MOVE")
                self._searches[phase] = Search(speed, declared.word(f"{name}_EDGE") == "RISING", move)
        self.resolver_offset = declared.optional("RESOLVER_OFFSET")
        self._left: list[str] = []
        """The phases behind the present one."""
        self._phase = ""
        self._searched: Search | None = None
        self._is_waiting_for_axis = False
        self._way: Profile | None = None
        self._began_in = 0
        self._job = 0
        self._fastest = self._strongest = math.inf
        """CKV and CKA of the ST1 in units of the axis, once they are known: the node limits a run to them."""
        site.events.append(self._read_limits)
        if sensor is not None:
            sensor.watchers.append(self._on_sensor)
        site.dependents.setdefault(axis.name, []).append(self.name)
        axis.watchers.append(self._on_axis)
        axis.on_stop.append(self._abort)

    # ---- programs

    def parameter(self, name: str) -> float:
        """Return COARSE_SPEED and so on; 0 stands for a word."""
        if name == "RESOLVER_OFFSET":
            return self.resolver_offset or 0.0
        phase, _, attribute = name.lower().partition("_")
        value: float | None = getattr(self._searches[phase], attribute)
        return value or 0.0

    def set_parameter(self, name: str, value: object) -> None:
        """Change a parameter of a phase that is declared; the phases themselves are fixed (PAML-201)."""
        number = float(value) if isinstance(value, int | float) else None
        if name == "RESOLVER_OFFSET":
            self.resolver_offset = number if self.resolver_offset is not None else None
            return
        phase, _, attribute = name.lower().partition("_")
        if phase in self._searches:
            setattr(self._searches[phase], attribute, number)

    def ask_ready(self) -> bool:
        return not self._phase and self._axis.is_ready

    def do_start(self) -> None:
        """Begin with the first phase; nothing happens while a pipe drives the axis (PAML-210)."""
        if self._axis.pipe is not None or self._phase:
            return
        self._left = [*self._searches, *(["resolver"] if self.resolver_offset is not None else []), "end"]
        self._next()
        self._site.kernel.touched(self.name)

    def do_stop(self) -> None:
        self._axis.do("stop")

    def _abort(self) -> None:
        if self._phase == "fine":
            self._fine_phases.leave(self._search)
        self._phase, self._left, self._searched, self._is_waiting_for_axis = "", [], None, False
        self._job += 1
        self._site.kernel.touched(self.name)

    # ---- phases

    def _next(self) -> None:
        if self._phase == "fine":
            self._fine_phases.leave(self._search)
        self._phase = self._left.pop(0)
        if self._phase == "fine":
            self._fine_phases.enter(self._search)
        elif self._phase == "coarse":
            self._search()
        elif self._phase == "resolver":
            self._job += 1
            job = self._job
            self._site.read(self._axis.node, Primary.MAIN_RESOLVER, lambda count: self._on_resolver(count, job))
        else:
            self._end()

    def _search(self) -> None:
        """Run at the speed of the phase, and wait for the edge also on the way to it (PAML-202)."""
        self._searched = search = self._searches[self._phase]
        axis = self._axis
        speed = axis.travel_speed if search.speed is None else search.speed
        top = min(max(speed, -self._fastest), self._fastest)
        acceleration = min(axis.acceleration, self._strongest)
        limits = Limits(abs(top) or 1.0, acceleration, acceleration)
        self._way, self._began_in = change_speed(0.0, top, limits), self._site.cycle
        axis.do("run", (speed,))

    def _read_limits(self) -> None:
        def put(attribute: str, count: int | None) -> None:
            if count:
                turn = MOTOR_TURN / abs(self._axis.units)
                setattr(self, attribute, count / COUNTS_PER_TURN * turn)

        for code, attribute in ((Parameter.CKV, "_fastest"), (Parameter.CKA, "_strongest")):
            self._site.read(self._axis.node, parameter_address(code), partial(put, attribute))

    def _on_sensor(self, is_true: bool, age_us: int) -> None:
        search = self._searched
        if search is None or is_true is not search.is_rising:
            return
        self._searched = None
        self._is_waiting_for_axis = True
        if search.move is None:
            self._axis.halt()
        else:
            self._axis.do("relative_move", (search.move - self._way_since_edge(age_us),))

    def _way_since_edge(self, age_us: int) -> float:
        """Return the way from the edge to the instant at which an order of this cycle works (PAML-203)."""
        site = self._site
        now_s = (site.cycle - self._began_in) * site.cycle_s
        back_s = age_us / 1e6 + site.readings.report_delay_cycles * site.cycle_s
        if self._way is None:
            return 0.0
        return self._way.values_at(now_s)[0] - self._way.values_at(max(now_s - back_s, 0.0))[0]

    def _on_axis(self) -> None:
        """Go on when the order of the phase is done; the end of a run before it may be noticed in the same cycle."""
        if self._is_waiting_for_axis and self._axis.is_ready:
            self._is_waiting_for_axis = False
            self._next()

    def _on_resolver(self, count: int | None, job: int) -> None:
        """Turn the motor to RESOLVER_OFFSET (PAML-208), the shorter way or by the other reading forward (G-39)."""
        if job != self._job or self.resolver_offset is None:
            return
        if count is None:
            self._abort()
            return
        axis, turn = self._axis, MOTOR_TURN
        angle = count % COUNTS_PER_TURN * turn / COUNTS_PER_TURN
        self._is_waiting_for_axis = True
        axis.do("relative_move", (nearest(self.resolver_offset * axis.units - angle, turn) / axis.units,))

    def _end(self) -> None:
        """The absolute position is 0 at the end (PAML-209)."""
        self._axis.do("position", (0.0,))
        self._phase = ""
        self._site.kernel.touched(self.name)
