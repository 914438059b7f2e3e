"""The interest of a member of a CAN bus: the frames and notices that it wants to receive.

None is every frame; a list of pairs `[identifier, mask]` is every frame that passes one of them; an empty list is none.
The pairs are SocketCAN's (Linux, Documentation/networking/can.rst, 4.1.1): a frame passes if
`received & mask == identifier & mask`, where `received` is the identifier with `EXTENDED` set for 29 bits and
`REMOTE` for a remote frame.  So

    [0x181, 0x7FF]                              11 bits 0x181, and any 29 bits that end in it
    [0x181, 0x7FF | EXTENDED]                   11 bits 0x181 only
    [0x18FEF100 | EXTENDED, 0x9FFFFFFF]         29 bits 0x18FEF100 only

The list may also contain the word "own": then each frame of the member itself comes back to it at its end on the wire,
as the confirmation that it was sent.  In the process of the bus model it is the same object that was sent (`is`).  Two
more words ask for notices of the member's own controller (see `notices`): "errors" for each error that it sees, "state"
for each change between error active, passive and bus-off.
Left out: SocketCAN's inverted filters.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig_bus.can.frame import CanFrame

EXTENDED: Final = 0x8000_0000
REMOTE: Final = 0x4000_0000
EVERYTHING: Final = (0, 0)
"""The pair that every frame passes, for an interest that contains words as well."""
OWN: Final = "own"
ERRORS: Final = "errors"
STATE: Final = "state"
_WORDS: Final = (OWN, ERRORS, STATE)

Filters = tuple[tuple[int, int], ...]


def received(frame: CanFrame) -> int:
    """The identifier of a frame with its flags, as filters see it."""
    identifier = frame.identifier
    if frame.is_extended:
        identifier |= EXTENDED
    if frame.is_remote:
        identifier |= REMOTE
    return identifier


def filters_of(interest: Sequence[Any] | None) -> Filters | None:
    """The pairs of an interest, ready for `passes`; None is every frame.  ValueError for anything else."""
    if interest is None:
        return None
    return tuple(_pair(each) for each in interest if each not in _WORDS)


def check_interest(interest: Any) -> None:
    """Raise ValueError or TypeError for an interest that no CAN bus can have."""
    for each in words_of(interest):
        if each not in _WORDS:
            _pair(each)


def wants_own(interest: Sequence[Any] | None) -> bool:
    return wants(interest, OWN)


def wants(interest: Sequence[Any] | None, word: str) -> bool:
    return interest is not None and word in interest


def passes(identifier: int, filters: Iterable[tuple[int, int]] | None) -> bool:
    """True if a frame passes the filters; `identifier` is the result of `received`."""
    return filters is None or any(identifier & mask == wanted for wanted, mask in filters)


def _pair(each: Any) -> tuple[int, int]:
    match each:
        case [int(identifier), int(mask)] if 0 <= identifier < 1 << 32 and 0 <= mask < 1 << 32:
            return identifier & mask, mask
    raise ValueError(f'{each!r} is not an acceptance filter: expected [identifier, mask], "own", "errors" or "state"')
