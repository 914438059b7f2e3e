"""The instants of a rig at which a log is played."""

from dataclasses import dataclass
from typing import NamedTuple

from fieldrig.clock import S


class Awaited(NamedTuple):
    """A node that is on when a log begins."""

    bus: str
    node: int
    answers: bool
    """True if it answers the first SDO in the log."""


@dataclass(frozen=True)
class Pace:
    """When a log is played."""

    begin_ns: int = 0
    """The instant of the rig at which the log begins."""
    log_ns: int = 0
    """The instant of the log that this is."""
    speed: float = 1.0
    """Seconds of the log in a second of the rig."""
    timeout_ns: int = S
    """Longest wait for an answer that the log shows."""
    heard_ns: int = 0
    """The instant of the rig from which on it has to send what the log has, and nothing else."""
    ready_ns: int = 0
    """The instant of the rig at which the nodes that are on when the log begins have to have booted."""
    awaited: tuple[Awaited, ...] = ()
    """These nodes; the log begins later if they boot later."""
    awaits_units: bool = False
    """True if Modbus units that do not answer at first may be booting."""
