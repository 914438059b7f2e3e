"""The streams that a comparison leaves out, by the words of a user."""

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from typing import Final

from fieldrig_devices.replay.streams import Stream

_HEX_DIGITS: Final = frozenset("0123456789abcdef")


def leaving_out(patterns: Sequence[str]) -> Callable[[Stream], bool]:
    """Return what says whether a stream is left out.

    A pattern is an identifier of CAN in hex (`185`, `0x185`, `185h`), the name of a wire, `unit 3*` or a sender, with
    the bus before it if need be (`can0/185`, `wires/*`).  A * matches any characters.
    """
    wanted = [_plain(pattern) for pattern in patterns]

    def is_left_out(stream: Stream) -> bool:
        text = stream.text.lower()
        short = text.lstrip("0") or "0"
        names = (text, short, f"{stream.bus}/{text}".lower(), f"{stream.bus}/{short}".lower())
        return any(fnmatchcase(name, pattern) for name in names for pattern in wanted)

    return is_left_out


def _plain(pattern: str) -> str:
    """Return a pattern in small letters; an identifier has no marks of its base."""
    bus, slash, name = pattern.lower().rpartition("/")
    if name.startswith("0x"):
        name = name[2:]
    elif name.endswith("h") and name[:-1] and set(name[:-1]) <= _HEX_DIGITS:
        name = name[:-1]
    return f"{bus}{slash}{name}"
