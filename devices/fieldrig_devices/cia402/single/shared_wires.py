"""One link to the wires for several parts of a device, each with an end and an interest of its own."""

from collections.abc import Callable, Sequence

from fieldrig.link import Link
from fieldrig_bus.wires import Signal

_Handler = Callable[[Signal], None]


class _End:
    def __init__(self, shared: "SharedWires") -> None:
        self._shared = shared

    def send(self, message: Signal) -> None:
        self._shared.wires.send(message)

    def on_receive(self, handler: _Handler, interest: Sequence[object] | None = None) -> None:
        """Take the signals of the wires that `interest` names; the parts of a device name all that they want."""
        self._shared.listen(self, handler, frozenset(map(str, interest or ())))


class SharedWires:
    """The link, and its ends."""

    def __init__(self, wires: Link[Signal]) -> None:
        self.wires = wires
        self._listeners: dict[_End, tuple[_Handler, frozenset[str]]] = {}

    def share(self) -> Link[Signal]:
        """Return a further end."""
        return _End(self)

    def listen(self, end: _End, handler: _Handler, names: frozenset[str]) -> None:
        self._listeners[end] = handler, names
        wanted = {name for _, interest in self._listeners.values() for name in interest}
        self.wires.on_receive(self._on_signal, sorted(wanted))

    def _on_signal(self, signal: Signal) -> None:
        for handler, names in tuple(self._listeners.values()):
            if signal.name in names:
                handler(signal)
