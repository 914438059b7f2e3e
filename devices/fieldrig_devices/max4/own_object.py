"""The controller itself in its object tree: its parameters, and the IEC Task objects.

Source: PacDrive manual 3604-3640, 4163-4196 (digest PD-020 to PD-025, PD-029, PD-096).
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, Protocol

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig_devices.iec.tasks.task import TaskState
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.com1.parameters import Port
from fieldrig_devices.max4.configuration.limits import CYCLES_MS
from fieldrig_devices.max4.configuration.tree import Access, ObjectTree, Parameter, Type
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.process import RealTimeProcess
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk

PRODUCT: Final = "MAx-4"
TASK_WORDS: Final = {int(state): state.name.replace("_", " ").lower() for state in TaskState}
"""Values of State of an IEC task (manual table 5-1)."""
_COUNTER: Final = 0xFFFF_FFFF
"""Timer1 and Timer10 are UDINT: Timer1 begins again after 49.7 days, while the boot counts on."""


class Tasks(Protocol):
    """The PLC, as parameters see it."""

    @property
    def load_percent(self) -> int | None:
        """CycleLoad as measured, or None while no program has been started."""

    def task_value(self, number: int, name: str) -> Value:
        """A value of the IEC task with this number, from 0: the parameters of its IEC Task object."""


class Cycles(Protocol):
    """The ring, as parameters see it."""

    def on_code(self, axis: Axis, code: int) -> None:
        """Called with each DiagCode that the drive of an axis shows."""

    def at_errors(self, address: int) -> int:
        """The number of ATs of a drive that did not arrive."""


class Owner(Controller, Protocol):
    """The controller, as the parameters of its own object see it."""

    @property
    def disk(self) -> FlashDisk: ...

    @property
    def com1(self) -> Port: ...

    @property
    def plc(self) -> Tasks: ...

    @property
    def cycles(self) -> Cycles: ...

    def now_ms(self) -> int:
        """Timer1, without its overflow."""


def add_own_parameters(tree: ObjectTree, process: RealTimeProcess, settings: Max4Settings, owner: Owner) -> None:
    """Add the parameters of the controller itself."""
    _add_general(tree, process, owner)
    _add_diagnosis(tree, process, settings, owner)
    identity = settings.identity
    for name, text in (
        ("SoftwareVersion", settings.version),
        ("ProductName", PRODUCT),
        ("ArticleNumber", identity.article_number),
        ("SerialNumber", identity.serial_number),
        ("HardwareCode", identity.hardware_code),
    ):
        tree.root.group("Versions").add(Parameter(name, Type.STRING, first=text))


def _add_general(tree: ObjectTree, process: RealTimeProcess, owner: Owner) -> None:
    def set_filter(mask: Value) -> None:
        owner.logger.filter = int(mask)

    general = tree.root.group("General")
    general.add(
        Parameter(
            "MsgFilter", Type.UINT, Access.INPUT_INIT, 0xFFFF, about="mask of the message classes that are recorded"
        )
    ).watcher = set_filter
    general.add(Parameter("CycleTime", Type.UINT, Access.INPUT_INIT, process.cycle_ns // MS, unit="ms", only=CYCLES_MS))
    general.add(Parameter("RetainInit", Type.BOOL, Access.INPUT_INIT, about="true: clear retained values at each boot"))


def _add_diagnosis(tree: ObjectTree, process: RealTimeProcess, settings: Max4Settings, owner: Owner) -> None:
    def load() -> Value:
        measured = owner.plc.load_percent
        return process.load_percent if measured is None else measured

    group = tree.root.group("Diagnosis")
    readings: tuple[tuple[str, Type, str, Callable[[], Value]], ...] = (
        ("DiagCode", Type.UINT, "", lambda: owner.diagnosis.code),
        ("DiagExtCode", Type.STRING, "", lambda: owner.diagnosis.ext),
        ("DiagMsg", Type.STRING, "", lambda: owner.diagnosis.msg),
        ("MsgEntries", Type.UINT, "", lambda: len(owner.logger)),
        ("Timer1", Type.UDINT, "ms", lambda: owner.now_ms() & _COUNTER),
        ("Timer10", Type.UDINT, "10ms", lambda: owner.now_ms() // 10 & _COUNTER),
        ("CycleLoad", Type.UINT, "%", load),
        ("RTBReadRes", Type.DINT, "us", lambda: process.read_reserve_us),
        ("RTBWriteRes", Type.DINT, "us", lambda: process.write_reserve_us),
        ("Diskfree", Type.UDINT, "Byte", lambda: owner.disk.free),
        ("Memoryfree", Type.UDINT, "Byte", lambda: settings.memory_free_bytes),
    )
    for name, type, unit, read in readings:
        group.add(Parameter(name, type, unit=unit, read=read))
    group.add(trigger("DiagQuit", owner.quit_all, "acknowledge (quit) the diagnoses of the controller and all axes"))


def add_tasks(tree: ObjectTree, symbols: Sequence[str], tasks: Tasks) -> None:
    """Add IEC Task objects, each of which observes the task of the same number (PD-029)."""

    def measured(enable: Parameter, number: int, name: str) -> Value:
        return tasks.task_value(number, name) if enable.value else 0

    for number, symbol in enumerate(symbols):
        general = tree.root.add("IEC Task", "IEC_TASK", symbol).group("General")
        general.add(Parameter("State", Type.UINT, read=partial(tasks.task_value, number, "State"), words=TASK_WORDS))
        enable = general.add(Parameter("EnableLoad", Type.BOOL, Access.INPUT, about="true: measure Load and Cycle"))
        for name in ("Load", "Cycle"):
            general.add(Parameter(name, Type.UDINT, unit="us", read=partial(measured, enable, number, name)))


def trigger(name: str, action: Callable[[], None], about: str) -> Parameter:
    """Return a parameter that calls `action` when it is set to true, and always reads false."""

    def write(value: Value) -> None:
        if value:
            action()

    return Parameter(name, Type.BOOL, Access.INPUT, read=lambda: False, write=write, about=about)
