"""Controllers whose program can be exchanged at an instant, for tests of programs that are changed."""

from collections.abc import Iterable, Iterator
from typing import Protocol, runtime_checkable

from fieldrig_devices.iec.controller.downloads import Downloads
from fieldrig_devices.iec.controller.order import Order
from fieldrig_devices.iec.loaded import LoadedProgram


class Plc(Protocol):
    downloads: Downloads

    @property
    def program(self) -> LoadedProgram | None: ...

    def present_order(self) -> Order:
        """Return the order to compile the present program again."""


@runtime_checkable
class Programmed(Protocol):
    """A device with a PLC."""

    @property
    def plc(self) -> Plc: ...


def plcs_of(devices: Iterable[object]) -> Iterator[Plc]:
    """Yield the PLCs of those devices that have one."""
    yield from (device.plc for device in devices if isinstance(device, Programmed))


def are_quiet(plcs: Iterable[Plc]) -> bool:
    """Return whether each of them has a program, and no task within a cycle."""
    return all(plc.program is not None and plc.program.scheduler.is_quiet for plc in plcs)


def exchange(plcs: Iterable[Plc], file: str) -> None:
    """Compile the programs that have this file again, and go on with them.  They have to be quiet.

    CompileError with every mistake of the first one that does not compile.
    """
    for plc in plcs:
        if plc.program is not None and any(one.name == file for one in plc.program.compiled.files):
            plc.downloads.exchange(plc.present_order())
