"""The variables, equations, inputs and outputs of an application as points of the rig, by their names.

`IFV_Each[2]` is the second item of a multiple object.  Encoders are left out, as their answers take several cycles.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

from fieldrig.device import Point, Value
from fieldrig_devices.pam.language.functions import VALUES, WRITABLE
from fieldrig_devices.pam.runtime.compiler import Compiled
from fieldrig_devices.pam.runtime.debug_values import Values
from fieldrig_devices.pam.runtime.layout import START
from fieldrig_devices.pam.runtime.runtime import Runtime

_LEFT_OUT: Final = ("ENCODER", "PAMDISPLAY")


def variable_points(compiled: Compiled, present: Callable[[], Runtime | None]) -> Iterator[tuple[str, Point]]:
    """Yield the points of an application; `present` returns it once its programs have begun."""
    layout = compiled.layout
    for name, kind in layout.kinds.items():
        if kind not in VALUES or kind in _LEFT_OUT:
            continue
        cells = layout.cells.get(name)
        is_group = layout.counts[name] > 1 if cells is None else cells.is_multiple
        is_writable = kind in WRITABLE if cells is None else not cells.is_equation
        paths = [f"{name}[{item + 1}]" for item in range(layout.counts[name])] if is_group else [name]
        for path in paths:
            write = partial(_write, present, path) if is_writable else None
            yield path, Point(partial(_read, present, path, START[VALUES[kind]]), write, about=kind)


def _read(present: Callable[[], Runtime | None], path: str, start: Value) -> Value:
    runtime = present()
    value = None if runtime is None else Values(runtime).evaluate(path, 0).value
    return start if value is None else value


def _write(present: Callable[[], Runtime | None], path: str, value: Value) -> None:
    runtime = present()
    if runtime is None:
        raise ValueError(f"{path}: expected an application that runs")
    Values(runtime).write(path, value)
