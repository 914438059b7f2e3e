"""What a face sees of the controller: axes, tree, messages, disk, and the cycle."""

from collections.abc import Callable, Mapping
from typing import Protocol

from fieldrig.store import Store
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.messages.diagnosis import Diagnosis, Sender
from fieldrig_devices.max4.messages.logger import Logger


class Controller(Protocol):
    @property
    def axes(self) -> Mapping[str, Axis]:
        """By symbolic name, in the order of the configuration.  The same objects from power-on to reset."""

    @property
    def tree(self) -> ObjectTree: ...

    @property
    def logger(self) -> Logger: ...

    @property
    def diagnosis(self) -> Diagnosis:
        """The controller's own, which shows the worst of all."""

    @property
    def cycle_ns(self) -> int:
        """Of the ring: 1, 2 or 4 ms."""

    @property
    def is_booted(self) -> bool: ...

    def each_cycle(self, action: Callable[[], None]) -> None:
        """Call `action` in every cycle of the real-time process, after the actual values are there and before set
        values are asked for; also while the ring is down."""

    def on_boot(self, action: Callable[[], None]) -> None:
        """Call `action` whenever a boot has begun (power-on, system reset): axes and tree may be others now."""

    def on_end(self, action: Callable[[], None]) -> None:
        """Call `action` at power-off, and at a reset before the next boot: nothing may be sent any more."""

    def quit_all(self) -> None:
        """Quit the diagnoses of the controller and of all axes."""

    def report(self, code: int, sender: Sender, ext: str = "") -> None:
        """A code of the catalogue has come."""

    def tcp_connected(self, peer: str) -> None:
        """A server has taken a connection from this IP address: entry 8013."""

    def section(self, name: str) -> Store:
        """Non-volatile memory for a face, on the flash disk."""
