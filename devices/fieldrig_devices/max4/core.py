"""The controller as its faces see it: axes, tree, messages, disk, and the cycle."""

from collections.abc import Callable, Mapping
from typing import Protocol

from fieldrig.storage.store import Store
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.messages.diagnosis import Diagnosis, Sender
from fieldrig_devices.max4.messages.logger import Logger
from fieldrig_devices.max4.reports import Language


class Controller(Protocol):
    """The services of the controller for a face."""

    @property
    def axes(self) -> Mapping[str, Axis]:
        """The axes by symbolic name, in the order of the configuration; they are replaced at each boot."""

    @property
    def tree(self) -> ObjectTree: ...

    @property
    def logger(self) -> Logger: ...

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis of the controller itself, which shows the most severe of all."""

    @property
    def cycle_ns(self) -> int:
        """Cycle time of the ring: 1, 2 or 4 ms, in nanoseconds."""

    @property
    def is_booted(self) -> bool: ...

    @property
    def language(self) -> Language:
        """The language of the messages."""

    @property
    def markers(self) -> bytearray | None:
        """The area %M of the program; None while no program is loaded."""

    def each_cycle(self, action: Callable[[], None]) -> None:
        """Call `action` in every cycle of the real-time process, between actual values and set values.

        The process also runs while the ring is down.
        """

    def at_priority(self, priority: int, duration_us: int, action: Callable[[], None]) -> None:
        """Call `action` when it is the turn of this IEC priority, which takes processor time from the program.

        It is called at once while no program runs.
        """

    def on_boot(self, action: Callable[[], None]) -> None:
        """Call `action` at the start of each boot (power-on, system reset), with new axes and a new tree."""

    def on_end(self, action: Callable[[], None]) -> None:
        """Call `action` at power-off, and at a reset before the next boot; nothing may be sent after it."""

    def quit_all(self) -> None:
        """Acknowledge (quit) the diagnoses of the controller and of all axes."""

    def report(self, code: int, sender: Sender, ext: str = "") -> None:
        """Report a code of the catalogue, in the log and as a diagnosis."""

    def tcp_connected(self, peer: str) -> None:
        """Report that a server has accepted a connection from this IP address (entry 8013)."""

    def section(self, name: str) -> Store:
        """Non-volatile memory of a face, on the flash disk."""
