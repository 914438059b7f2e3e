"""The messages of a PAM: what the debugger prints of each, and the list of errors (PAMS-044, PAMS-047)."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from fieldrig_devices.pam.panel.catalogue import origin_name
from fieldrig_devices.pam.panel.codes import LISTED, Code, Kind

MOST_PRINTED: Final = 200
"""Lines of the debugger that are kept."""
MOST_LISTED: Final = 100
"""Entries of the error list; the manual gives no number."""

_WORDS: Final = {
    Kind.MESSAGE: "Message",
    Kind.WARNING: "Warning",
    Kind.END_WARNING: "Warning Canceled",
    Kind.ERROR: "Error",
    Kind.END_ERROR: "Error Canceled",
    Kind.FATAL: "Fatal Error",
}


@dataclass(frozen=True, slots=True)
class Message:
    """A message with the data fields D1 to D3 that are shown beside its code."""

    code: Code
    text: str
    details: tuple[int | float, ...]
    date: datetime

    def lines(self) -> tuple[str, str]:
        """Return what the debugger prints (manual lines 8733 to 8745)."""
        words = f"{'real time ' * self.code.is_real_time}{_WORDS[self.code.kind]}"
        fields = " ".join(_shown(detail) for detail in self.details)
        head = f"{self.date:%d.%m.%y %H:%M:%S} [{self.code}] {words}"
        return head, f"{origin_name(self.code)} {self.text} {fields}".strip()


def _shown(detail: int | float) -> str:
    return f"{detail & 0xFFFF_FFFF:X}" if isinstance(detail, int) else f"{detail:g}"


class Messages:
    """The messages since power-on."""

    def __init__(self, write: Callable[[bytes], None]) -> None:
        """`write` sends text to the debugger's serial line."""
        self._write = write
        self.listed: deque[Message] = deque(maxlen=MOST_LISTED)
        self.printed: deque[str] = deque(maxlen=MOST_PRINTED)
        self.fatal: Message | None = None
        """The first fatal error."""

    def add(self, message: Message) -> None:
        """Print a message, and list it if it is an error, a fatal error, or an end."""
        if message.code.kind in LISTED:
            self.listed.append(message)
        if message.code.is_fatal and self.fatal is None:
            self.fatal = message
        self._print(message.lines())

    def clear(self) -> None:
        """Forget all messages, at power-on."""
        self.listed.clear()
        self.printed.clear()
        self.fatal = None

    def _print(self, lines: Sequence[str]) -> None:
        self.printed.extend(lines)
        self._write("".join(f"{line}\r\n" for line in lines).encode("latin-1", "replace"))
