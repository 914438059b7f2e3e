"""Settings of a PAM's end of its ring; the manual gives only `frames_per_ms`, so the other values are ours."""

from dataclasses import dataclass
from typing import Final, Literal

from fieldrig.clock import MS, S

THIRDS_PER_MS: Final = 3


@dataclass(frozen=True, slots=True)
class RingLimits:
    """Limits of the ring, and the time-outs of the PAM."""

    thirds: int = 3
    """BASIC_PAM_CYCLE."""
    interface: Literal["asic", "fpga"] = "asic"
    """The optical interface, which tells how an interruption at run time is shown: 06..F010, or 06..F00C (B.7)."""
    frames_per_ms: int = 20
    """Free frames for set-points and commands (PAML-167)."""
    nodes_per_ms: int = 32
    """Peripherals for which the ring has time in a millisecond of the cycle (06..F016)."""
    reports_per_ms: int = 256
    """Reports that the PAM handles; more of them wait in its reception FIFO."""
    reception_fifo: int = 1_024
    """Reports that may wait (06..F009)."""
    sending_fifo: int = 1_024
    """Commands that may wait for a free frame (07..E006)."""
    boot_ns: int = 2 * S
    """Time that the nodes have after power-on, until all that are declared are on the ring."""
    identify_ns: int = 500 * MS
    """Time that a node has for its ready token (06..F005)."""
    acknowledge_ns: int = 500 * MS
    """Time for an acknowledge since the last one came (07..F016, 07..F017)."""
    first_value_ns: int = 2 * S
    """Time for the first values of all inputs since the last one came (07..E021)."""

    @property
    def frames_per_cycle(self) -> int:
        """Free frames in a basic cycle."""
        return max(1, self.frames_per_ms * self.thirds // THIRDS_PER_MS)

    @property
    def most_nodes(self) -> int:
        """Peripherals for which the cycle has time."""
        return max(1, self.nodes_per_ms * self.thirds // THIRDS_PER_MS)

    @property
    def reports_per_cycle(self) -> int:
        """Reports that the PAM handles in a basic cycle."""
        return max(1, self.reports_per_ms * self.thirds // THIRDS_PER_MS)
