"""All of it as one library of a program."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec.host import Library, NativeBlock, NativeFunction, Results
from fieldrig_devices.iec.tcunit.files import declared, fields, search
from fieldrig_devices.iec.tcunit.files.disk import Disk
from fieldrig_devices.iec.tcunit.files.rings import TEXT as RINGS
from fieldrig_devices.iec.tcunit.files.rings import Rings
from fieldrig_devices.iec.types import Value

FILE: Final = "TwinCAT files"
COST_NS: Final = 5_000


@dataclass(slots=True)
class _Work:
    """The state of one block."""

    was_executed: bool = False
    outputs: tuple[Value, ...] = ()
    next: tuple[Value, ...] | None = None
    """The outputs after the next call."""


@dataclass(slots=True)
class Files:
    """The files of one run, and the state of the blocks that work with them."""

    disk: Disk = field(default_factory=Disk)
    rings: Rings = field(default_factory=Rings)
    _works: dict[Hashable, _Work] = field(default_factory=dict)

    def library(self) -> Library:
        """Return the library with its text and its functions."""
        actions: dict[str, Callable[..., Results]] = {
            "FB_FileOpen": self.disk.opened,
            "FB_FileClose": self.disk.closed,
            "FB_FileRead": self.disk.read,
            "FB_FileWrite": self.disk.write,
            "FB_FileSeek": self.disk.seek,
            "FB_FileTell": self.disk.tell,
            "FB_EOF": self.disk.end,
            "FB_FileGets": self.disk.gets,
            "FB_FilePuts": self.disk.puts,
            "FB_FileDelete": self.disk.delete,
            "FB_FileRename": self.disk.rename,
            "FB_CreateDir": self.disk.create_folder,
            "FB_RemoveDir": self.disk.remove_folder,
        }
        blocks = {name.lower(): NativeBlock(self._block(name, action), COST_NS) for name, action in actions.items()}
        memory = self.disk.memory_of_program
        functions = {
            "fieldrig_files_find": NativeFunction(self.disk.find, COST_NS),
            "fieldrig_files_field": NativeFunction(lambda *given: fields.field_at(memory(), *given), COST_NS),
            "fieldrig_files_put": NativeFunction(lambda *given: fields.put(memory(), *given), COST_NS),
            "fieldrig_files_ring": NativeFunction(self.rings.act, COST_NS),
        }
        text = f"{declared.text()}{search.TEXT}{fields.TEXT}{RINGS}"
        return Library(FILE, text, functions, blocks)

    def _block(self, name: str, action: Callable[..., Results]) -> Callable[..., Results]:
        """Return what one call of a block does.  The action gives the error, 0 if there is none, then the outputs."""
        form = declared.FORMS[name]

        def run(address: int, *inputs: Value) -> Results:
            work = self._works.setdefault((name, address), _Work(outputs=(False, False, 0, *form.initial)))
            if work.next is not None:
                work.outputs, work.next = work.next, None
            is_executed = bool(inputs[form.execute])
            if is_executed and not work.was_executed:
                given = [value for number, value in enumerate(inputs[:-1]) if number not in (0, form.execute)]
                error, *outputs = action(*given)
                work.next = (False, bool(error), error, *(outputs or form.initial))
                work.outputs = (True, False, 0, *work.outputs[3:])
            work.was_executed = is_executed
            return work.outputs

        return run
