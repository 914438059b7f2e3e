"""Options of a run of the suite."""

from dataclasses import dataclass

FIRST_TIMEOUT = 4
"""Factor by which the first time-out exceeds the usual one."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of a run, with times in milliseconds."""

    timeout_ms: int = 500
    """Time-out of an answer, from which all other times are derived.  It adapts to a slower node: see `Sdo`."""
    boot_ms: int = 5000
    """Time-out of a boot-up, and upper limit of the adapted time-out of an answer."""
    may_store: bool = True
    """True if the cases may write the node's non-volatile memory, which is restored afterwards."""
    is_alone: bool = False
    """True if there is no other node on the bus, so that NMT commands to all nodes are harmless."""

    @property
    def first_timeout_ms(self) -> int:
        """Time-out until the first answer, which shows how fast the node is."""
        return min(self.boot_ms, FIRST_TIMEOUT * self.timeout_ms)
