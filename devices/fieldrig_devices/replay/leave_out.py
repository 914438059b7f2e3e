"""The streams that a comparison leaves out, by the words of a user."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from typing import Final

from fieldrig.text.nearest import closest
from fieldrig_devices.replay.streams import Stream

MOST_NAMES: Final = 2_000
"""Names of streams that are kept for the nearest one."""
_HEX_DIGITS: Final = frozenset("0123456789abcdef")


class LeftOut:
    """Says whether a stream is left out, and which words have named none.

    A pattern is an identifier of CAN in hex (`185`, `0x185`, `185h`), the name of a wire, `unit 3*` or a sender, with
    the bus before it if need be (`can0/185`, `wires/*`).  A * matches any characters.
    """

    def __init__(self, patterns: Sequence[str]) -> None:
        self._wanted = {pattern: _plain(pattern) for pattern in patterns}
        self._met: set[str] = set()
        self._names: dict[str, None] = {}

    def __call__(self, stream: Stream) -> bool:
        text = stream.text.lower()
        short = text.lstrip("0") or "0"
        names = (text, short, f"{stream.bus}/{text}".lower(), f"{stream.bus}/{short}".lower())
        met = [word for word, wanted in self._wanted.items() if any(fnmatchcase(name, wanted) for name in names)]
        self._met.update(met)
        if self._wanted and len(self._names) < MOST_NAMES:
            self._names.update(dict.fromkeys((stream.text, f"{stream.bus}/{stream.text}")))
        return bool(met)

    def unmet(self) -> Iterator[str]:
        """Yield a sentence about each word that names nothing in the logs."""
        for word in self._wanted:
            if word not in self._met:
                yield f"--leave-out {word}: the logs have no such stream; {closest(word, list(self._names))}"


def _plain(pattern: str) -> str:
    """Return a pattern in small letters; an identifier has no marks of its base."""
    bus, slash, name = pattern.lower().rpartition("/")
    if name.startswith("0x"):
        name = name[2:]
    elif name.endswith("h") and name[:-1] and set(name[:-1]) <= _HEX_DIGITS:
        name = name[:-1]
    return f"{bus}{slash}{name}"
