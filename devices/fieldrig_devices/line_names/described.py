"""The protocols that devices speak on their serial lines, for tools that name the messages.

A device says so by the method `line_reader` of its settings; without it a line is read as text, Hayes and PPP.
"""

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

Part = tuple[str, str]
"""Kind and text of one message of a protocol."""


class LineReader(Protocol):
    """Reads the bytes of one line, in the order in which they were sent."""

    def __call__(self, sender: str, data: bytes) -> Sequence[Part]:
        """Return what these bytes of one end complete; nothing for a part of a message."""


@runtime_checkable
class HasLines(Protocol):
    """The settings of a device that speaks a protocol of its own on a serial line."""

    def line_reader(self, link: str, device: str) -> LineReader | None:
        """Return a new reader of the line at a link of `device`; None for a line of plain text."""
