"""Links that tolerate a busy host: a bus in real time may grant its members extra time for an answer."""

from typing import Any, Protocol, runtime_checkable


@runtime_checkable
class PatientLink(Protocol):
    """A link of a bus that grants its members extra time."""

    @property
    def patience_ns(self) -> int:
        """Return the extra time for an answer, in nanoseconds; 0 in virtual time."""


def patience_of(link: Any) -> int:
    """Return the extra time that a link grants, in nanoseconds; 0 for a link without that ability, and for None."""
    return link.patience_ns if isinstance(link, PatientLink) else 0
