"""A VME master as a device: it starts a PAM over Modbus, serves the watchdog, and has all variables as points.

It stands for the PLC in rigs without one.  When the PAM is gone, it begins the start-up again.
"""

import logging
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.errors import RigError
from fieldrig.faults.faults import LONGEST_MS, Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in, whole_in
from fieldrig.settings import Claim, ConfigFile, Settings
from fieldrig.text.source_text import decoded
from fieldrig_bus.modbus.message import ModbusEvent
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.refusal import refused
from fieldrig_devices.modbus.port import UnitId
from fieldrig_devices.pam.application_files import reader_beside
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.ports import PortPlan, PortVariable, ports_of
from fieldrig_devices.pam.ports.masters.over_modbus import ModbusScript
from fieldrig_devices.pam.ports.masters.script import MasterError, Pause, Script
from fieldrig_devices.pam.ports.masters.vme import VmeMaster
from fieldrig_devices.pam.ports.options import PortOptions
from fieldrig_devices.pam.runtime.item import Value as PamValue

log = logging.getLogger(__name__)

RETRY_NS: Final = 500 * MS
_BITS: Final = {"WORD_VAR": 16, "LONG_VAR": 32}


class VmeMasterSettings(Settings):
    application: ConfigFile = Field(description="source of the PAM's application, which declares the variables")
    unit_id: UnitId = 1
    cycle_ms: int = Field(
        default=10, ge=1, le=200, description="cycle of the master: watchdog, outputs, then inputs that have changed"
    )
    initial: dict[str, bool | int | float] = Field(
        default={}, description="initial values of inputs by name, for all their items; 0 for others"
    )
    ports: PortOptions = Field(default_factory=PortOptions, description="the same readings of the manual as the PAM's")

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("modbus", "master of the DualPort of unit", self.unit_id, ("unit_id",))

    def needs(self, device: str) -> Iterator[Claim]:
        yield Claim("modbus", "unit", self.unit_id, ("unit_id",))


class Stopped(Timed):
    """The master's program stands: it serves neither the watchdog nor the variables."""

    what: Literal["stopped"]


class Slow(Timed):
    """Each cycle of the master takes longer."""

    what: Literal["slow"]
    delay_ms: float = Field(gt=0, le=LONGEST_MS, description="time by which a cycle is longer")


MODELS: Final[Mapping[str, type[Any]]] = models_of(Annotated[Stopped | Slow, Field(discriminator="what")])


class VmeMasterDevice(Device):
    about: ClassVar[str] = "a VME master for a PAM, in the place of a PLC"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, settings: VmeMasterSettings, modbus: Link[ModbusEvent]) -> None:
        """ConfigError for an application with mistakes; RigError if it has no VME DualPort, or not all inputs."""
        self._settings = settings
        self._plan = _plan_of(settings)
        self._master = VmeMaster(self._plan.variables, settings.ports)
        self._wanted: dict[tuple[str, int], PamValue] = {}
        """Inputs that a user has written, until they are sent."""
        self._is_running = False
        self.injected = self._faults = InjectedFaults[Fault[Any]](clock, MODELS, Faults(Fault))
        self._script = ModbusScript(clock, modbus, settings.unit_id, self._work(), lambda: None)
        modbus.on_receive(self._script.on_message, [])  # a client

    def start(self) -> None:
        self._script.begin()

    def stop(self) -> None:
        self._script.stop()

    def _work(self) -> Script[None]:
        while True:
            try:
                yield from self._stand()
                yield from self._master.start_up(self._settings.initial)
                self._is_running = True
                while (yield from self._master.watch()):
                    yield from self._exchange()
                    slow = self._faults.first(Slow)
                    yield Pause(self._cycle_ns + (0 if slow is None else round(slow.delay_ms * MS)))
                    yield from self._stand()
            except MasterError as fault:
                log.debug("%s", fault)
            self._is_running = False
            yield Pause(RETRY_NS)

    @property
    def _cycle_ns(self) -> int:
        return self._settings.cycle_ms * MS

    def _stand(self) -> Script[None]:
        """Do nothing while a fault stops the master."""
        while self._faults.first(Stopped) is not None:
            yield Pause(self._cycle_ns)

    def _exchange(self) -> Script[None]:
        yield from self._master.take()
        for (name, index), value in list(self._wanted.items()):
            if not (yield from self._master.put(name, value, index)):
                return
            if self._wanted.get((name, index)) == value:
                del self._wanted[name, index]

    # ---- points

    def points(self) -> Mapping[str, Point]:
        by_key = {
            "running": Point(lambda: self._is_running, about="the start-up is over, and the PAM is alive"),
            "mistakes": Point(lambda: "\n".join(self._master.mistakes), about="definitions of the PAM that differ"),
        }
        for variable in self._plan.variables:
            for index in range(variable.number):
                key = f"{variable.name}.{index}" if variable.is_multiple else variable.name
                write = partial(self._write, variable, index) if variable.is_input else None
                by_key[key] = Point(partial(self._read, variable.name, index), write)
        return by_key

    def _read(self, name: str, index: int) -> Value:
        """Return the value of a variable, or that which a user has written and the master sends next."""
        return self._wanted.get((name, index), self._master.values[name][index])

    def _write(self, variable: PortVariable, index: int, value: Value) -> None:
        if variable.kind == "FLAG_VAR":
            self._wanted[variable.name, index] = truth_in(value)
        elif variable.kind == "REAL_VAR":
            self._wanted[variable.name, index] = number_in(value)
        else:
            half = 1 << _BITS[variable.kind] - 1
            self._wanted[variable.name, index] = whole_in(value, -half, half - 1)


def _plan_of(settings: VmeMasterSettings) -> PortPlan:
    path = settings.application
    program, mistakes = checked(decoded(path.read_bytes()), path.name, reader_beside(path))
    if any(not mistake.is_note for mistake in mistakes):
        raise refused(CompileError(mistakes), {path.name: str(path)})
    plan = next((plan for plan in ports_of(program) if plan.kind == "VME DUALPORT"), None)
    if plan is None:
        raise RigError(f"{path.name} has no VME DUALPORT", "a master of this kind needs one")
    unknown = sorted(settings.initial.keys() - {variable.name for variable in plan.inputs})
    if unknown:
        raise RigError(f"initial: {path.name} has no input {unknown[0]}", "expected inputs of its VME DUALPORT")
    return plan
