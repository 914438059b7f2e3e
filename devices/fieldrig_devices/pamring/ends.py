"""The two ends of a PAM's ring, as the programs of the PAM and of its nodes see them."""

from enum import Enum
from typing import Protocol

from fieldrig_devices.pamring.frames import Configuration, Order, Report


class RingFault(Enum):
    """The state of the ring as a node sees it (section 3.3: the local display, and the LEDs of the interface)."""

    NONE = "none"
    INACTIVE = "inactive"
    """No cycle arrives: F 2."""
    CARRIER = "carrier"
    """The first node behind a break: F-6."""
    CRC = "crc"
    """The first node behind a place where frames are damaged: F-7.

    If the ring falls silent then, `INACTIVE` and `CRC` follow at once, so that the node reacts as others do.
    """


class PamPort(Protocol):
    """The PAM's end of the ring, for its objects.  What is sent leaves with the next basic cycle."""

    def send(self, address: int, order: Order) -> None:
        """Send an order to a node; to `BROADCAST`, to all of them."""

    def send_to_group(self, group: int, order: Order) -> None:
        """Send an order to the nodes that have joined this `Group`, in one frame (PAML-162)."""


class ReportHandler(Protocol):
    """The receiver of the reports of all nodes, in the PAM."""

    def on_report(self, address: int, report: Report) -> None:
        """Take a report of an active node, at the beginning of a basic cycle.

        A `Trouble` has been shown as a message already; its error word is the objects' business.
        """


class NodePort(Protocol):
    """A node's end of the ring, for its program."""

    def send(self, report: Report) -> None:
        """Lay a report into the buffer; the PAM has it in the next basic cycle."""


class NodeProgram(Protocol):
    """The program of a node, which carries out the orders of the PAM.

    The node's end answers `Identify`, `Run` and configurations itself.
    """

    def forget(self) -> None:
        """Forget the items and switch outputs off, as `Identify` has arrived."""

    def accept(self, item: Configuration) -> bool:
        """Take an item of the configuration; False if this node cannot have it."""

    def run(self) -> None:
        """Scan inputs from now on, as `Run` has arrived; each input reports its first value."""

    def order(self, order: Order) -> None:
        """Carry out an order.  One for an item that it does not have is answered by `Trouble` 0Bh."""

    def cycle(self) -> None:
        """React to a basic cycle whose orders have been carried out."""

    def ring(self, fault: RingFault) -> None:
        """Take the new state of the ring as the node sees it."""
