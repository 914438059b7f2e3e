"""Functions of the controller that programs call; the motion libraries are in `max4/libraries`.

Source: PacDrive manual 3072, 3213, 3256, 3411-3416, 4219-4280 (digest PD-028, PD-077, PD-078, PD-080, PD-119).  The
manual names them without their arguments, which are our choice.  Functions of the flash disk are slow.
"""

from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig_devices.iec.host import Library, NativeFunction, Pending, Results
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.max4.libraries.collection import motion_libraries
from fieldrig_devices.max4.libraries.controller import SystemMotion
from fieldrig_devices.max4.messages.diagnosis import Sender
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.plc.library.open_files import OpenFiles, disk_name
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.system import System

DONE: Final = 0
UNKNOWN: Final = -1
REFUSED: Final = -2
WRONG: Final = -3
APPEND_MS: Final = 300
"""AppendToWriteFile takes "several 100 ms" (manual 3414); so does all else that writes to the flash disk."""
ACCESS_MS: Final = 20
"""Other accesses to the flash disk."""


class Functions:
    """The functions of one controller."""

    def __init__(
        self, clock: Clock, disk: FlashDisk, logger: Logger, present: Callable[[], LoadedProgram | None]
    ) -> None:
        """`present` returns the program that is loaded."""
        self._clock, self._disk, self._logger, self._present = clock, disk, logger, present
        self._files = OpenFiles(disk)

    def libraries(self, system: System) -> tuple[Library, ...]:
        """The libraries for the objects of a boot."""
        motion = motion_libraries(SystemMotion(system, self._disk))
        return (Library("MAx-4.lib", _TEXT, self._functions(system), {}), *motion)

    def end(self) -> None:
        """Close all files without writing them, at the end of the program."""
        self._files.drop()

    def _functions(self, system: System) -> Mapping[str, NativeFunction]:
        logger = self._logger
        axes = {axis.log_adr: axis for axis in system.axes.values()}

        def enable(address: int, is_on: bool) -> Results:
            if address not in axes:
                return (UNKNOWN,)
            axes[address].enable(is_on)
            return (DONE,)

        def reset_log() -> Results:
            logger.reset()
            return (DONE,)

        slow = self._slow
        return {
            "controllerenableset": NativeFunction(enable, cost_ns=5_000),
            "cyclechecktimeset": NativeFunction(self._set_check_time),
            "waitt": NativeFunction(self._wait, is_slow=True),
            "msglogsave": slow(APPEND_MS, lambda name: _done(lambda: logger.save(disk_name(name)))),
            "msglogreset": NativeFunction(reset_log),
            "msglogdelete": slow(APPEND_MS, lambda name: _done(lambda: logger.delete(disk_name(name)))),
            "msgloginsert": NativeFunction(self._insert, cost_ns=20_000),
            "appendtowritefile": slow(APPEND_MS, lambda name, text: _done(lambda: self._files.append(name, text))),
            "fileopen": slow(ACCESS_MS, self._files.open),
            "fileread": slow(ACCESS_MS, self._files.read),
            "filewrite": slow(ACCESS_MS, self._files.write),
            "fileeof": NativeFunction(lambda file: (self._files.is_at_end(file),)),
            "fileclose": slow(APPEND_MS, self._files.close),
            "filedelete": slow(APPEND_MS, lambda name: _done(lambda: self._disk.delete(disk_name(name)))),
            "filesize": slow(ACCESS_MS, self._files.size),
        }

    def _slow(self, duration_ms: int, run: Callable[..., Results]) -> NativeFunction:
        """A function whose effect and result come after some time, for which it holds its task."""

        def begin(*inputs: bool | int | float | str) -> Pending:
            pending = Pending()
            self._after(duration_ms, lambda: pending.finish(*run(*inputs)))
            return pending

        return NativeFunction(begin, cost_ns=20_000, is_slow=True)

    def _after(self, duration_ms: int, action: Callable[[], None]) -> None:
        """Do something later, unless the program has ended by then."""
        program = self._present()

        def act() -> None:
            if self._present() is program:
                action()

        self._clock.call_at(self._clock.now_ns() + duration_ms * MS, act)

    def _wait(self, time_ms: int) -> Pending:
        pending = Pending()
        self._after(time_ms, lambda: pending.finish(DONE))
        return pending

    def _set_check_time(self, time_ms: int) -> Results:
        program = self._present()
        if time_ms < 0 or program is None or program.scheduler.current is None:
            return (WRONG,)
        program.scheduler.set_check_time(program.scheduler.current, time_ms * MS)
        return (DONE,)

    def _insert(self, type: int, code: int, ext: str, text: str) -> Results:
        program = self._present()
        task = program.scheduler.current if program is not None else None
        sender = Sender("IEC_TASK", task.name if task is not None else "")
        self._logger.insert(type, sender, code, ext, text)
        return (DONE,)


def _done(action: Callable[[], None]) -> Results:
    """Carry out an action of the flash disk, and return what it made of it."""
    try:
        action()
    except ValueError:
        return (REFUSED,)
    return (DONE,)


_TEXT: Final = (files(__name__) / "controller.st").read_text(encoding="ascii")
