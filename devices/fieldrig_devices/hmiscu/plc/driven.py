"""The points that a program drives: a value from outside would be gone in the next cycle, so each face refuses it.

These are the outputs of the controller that it writes, and the variables and pins of `iec/protected.py`.
"""

from collections.abc import Callable, Iterable

from fieldrig_devices.hmiscu import panel
from fieldrig_devices.hmiscu.io import place_of
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.loaded import LoadedProgram
from fieldrig_devices.iec.protected import Protected


class Driven:
    """The points that the present program drives."""

    def __init__(self, present: Callable[[], LoadedProgram | None], outputs: Iterable[str]) -> None:
        """`present` returns the program that is loaded; `outputs` are the names of all outputs."""
        self._present = present
        self._places = {name.casefold(): place_of(name) for name in outputs}
        self._compiled: Compiled | None = None
        self._variables: Protected | None = None
        self._known: dict[str, bool] = {}

    def has(self, name: str) -> bool:
        """Return whether the program drives the point of this name, in any case of letters."""
        program, key = self._present(), name.casefold()
        if program is None:
            return False
        # By the code and not by the program: an online change keeps the program, and may write other places.
        if self._compiled is not program.runtime.compiled:
            self._take(program.runtime.compiled)
        if key not in self._known:
            assert self._variables is not None
            self._known[key] = self._variables.has(name)
        return self._known[key]

    def is_output(self, name: str) -> bool:
        """Return whether this is an output or a lamp, which are off while the program does not run."""
        return name.casefold() in self._places or name.casefold().startswith("panel.lamp")

    def _take(self, compiled: Compiled) -> None:
        self._compiled, self._variables = compiled, Protected(compiled.written, compiled.symbols)
        bits = compiled.written.bits
        self._known = {name: (place.byte, max(place.bit, 0)) in bits for name, place in self._places.items()}
        self._known |= {f"panel.lamp{lamp + 1}": (panel.AREA_BYTE, lamp) in bits for lamp in range(panel.LAMPS)}
