"""A controller on a bench that runs IEC programs from texts."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from max4_bench import Bench

from fieldrig.clock import MS
from fieldrig_devices.iec.types import Value
from fieldrig_devices.max4.plc.loaded import RetainingProgram


class PlcBench(Bench):
    """`text` is the program, in a file `plc.st` in `folder`; autostart is on."""

    def __init__(self, folder: Path, text: str, *drives: str, files: Sequence[Path] = (), **settings: Any) -> None:
        """`files` are further source files."""
        self.file = folder / "plc.st"
        self.write(text)
        super().__init__(*drives, program=[str(self.file), *map(str, files)], **{"autostart": True, **settings})

    def write(self, text: str) -> Self:
        """Change the source, which the next download takes."""
        self.file.write_text(text)
        return self

    @property
    def loaded(self) -> RetainingProgram:
        program = self.max4.firmware.plc.program
        assert program is not None
        return program

    def value(self, path: str) -> Value:
        """Return a variable of the program."""
        runtime = self.loaded.runtime
        return runtime.read(runtime.find(path))

    def put(self, path: str, value: Value) -> Self:
        runtime = self.loaded.runtime
        runtime.write(runtime.find(path), value)
        return self

    def state(self, task: str) -> Value:
        return self.get(f"plc/task/{task}/state")

    def edges(self, wire: str) -> list[tuple[float, Any]]:
        """Return the changes of a wire with their times in ms."""
        return [(time_ns / MS, value) for time_ns, name, value in self.wires if name == wire]


def task_of(program: str, ms: float = 10, priority: int = 16, name: str = "T") -> str:
    """Return a task configuration with one task."""
    return f"""
CONFIGURATION c RESOURCE r ON PLC
TASK {name}(INTERVAL := T#{ms}ms, PRIORITY := {priority});
PROGRAM p WITH {name} : {program};
END_RESOURCE END_CONFIGURATION
"""
