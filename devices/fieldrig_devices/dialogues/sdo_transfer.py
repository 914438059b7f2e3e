"""An SDO transfer as a log shows it: one read or write of an object, with all its segments."""

from dataclasses import dataclass
from typing import Literal

Form = Literal["expedited", "segmented", "block"]


@dataclass(frozen=True, slots=True)
class SdoTransfer:
    """A transfer from its first request to its last answer, or as far as it went."""

    begin_ns: int
    end_ns: int | None
    bus: str
    entries: tuple[int, ...]
    node_id: int
    """Node-ID of the server."""
    index: int
    subindex: int
    is_download: bool
    """True if the client wrote the object."""
    data: bytes | None
    """The whole content; of a download that failed, what the client sent.  None if a part of it is not known."""
    abort: int | None
    """The abort code, if one side ended the transfer so."""
    form: Form
    abort_by_client: bool = False
    size: int | None = None
    """The size that was announced, in bytes."""
    wrong: str = ""
    """A deviation from the standard, or a gap in the log, in words; empty if the transfer was as it should be."""
    request_id: int = 0
    """The CAN identifier of the client's messages; bit 31 marks one of 29 bits."""

    @property
    def is_answered(self) -> bool:
        """True if the server said anything.  An abort of the client after its request, as at a time limit, is none."""
        return self.end_ns is not None and not (self.abort_by_client and len(self.entries) <= 2)

    @property
    def is_done(self) -> bool:
        """True if both sides completed the transfer."""
        return self.end_ns is not None and self.abort is None
