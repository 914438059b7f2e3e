"""The points that a program drives: a value from outside would be gone in the next cycle, so each face refuses it.

These are the outputs of the controller that it writes, and the variables and pins of `iec/protected.py`.
"""

from collections.abc import Iterable

from fieldrig_devices.hmiscu import panel
from fieldrig_devices.hmiscu.io import place_of
from fieldrig_devices.iec.compiler import Compiled
from fieldrig_devices.iec.protected import Protected


class Driven:
    """The points that one program drives."""

    def __init__(self, compiled: Compiled, terminals: Iterable[str]) -> None:
        """`terminals` are the names of all outputs."""
        self._variables = Protected(compiled.written, compiled.symbols)
        bits = compiled.written.bits
        places = {name.casefold(): place_of(name) for name in terminals}
        self._known = {name: (place.byte, max(place.bit, 0)) in bits for name, place in places.items()}
        self._known |= {f"panel.lamp{lamp + 1}": (panel.AREA_BYTE, lamp) in bits for lamp in range(panel.LAMPS)}

    def has(self, name: str) -> bool:
        """Return whether the program drives the point of this name, in any case of letters."""
        key = name.casefold()
        if key not in self._known:
            self._known[key] = self._variables.has(name)
        return self._known[key]
