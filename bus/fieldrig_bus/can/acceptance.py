"""Which frames a member of a CAN bus wants to hear: its `interest`.

None is every frame, and a list of pairs `[identifier, mask]` those that pass any of them; an empty list is silence.
The pairs are SocketCAN's (Linux, Documentation/networking/can.rst, 4.1.1): a frame passes if
`received & mask == identifier & mask`, where `received` is the identifier with `EXTENDED` set for 29 bits and
`REMOTE` for a remote frame.  So

    [0x181, 0x7FF]                              11 bits 0x181, and any 29 bits that end in it
    [0x181, 0x7FF | EXTENDED]                   11 bits 0x181 only
    [0x18FEF100 | EXTENDED, 0x9FFFFFFF]         29 bits 0x18FEF100 only

Beside the pairs may stand the word "own": then all frames of the member itself come back to it, at the end of each on
the wire, as the confirmation that it was sent.  In the process of the bus model that is the very object that was
sent (`is`).  Two more words ask for what the member's own controller has to say (see `notices`): "errors" for each
error that it sees, "state" for each change between error active, passive and bus-off.  SocketCAN's inverted filters
are left out.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig_bus.can.frame import CanFrame

EXTENDED: Final = 0x8000_0000
REMOTE: Final = 0x4000_0000
EVERYTHING: Final = (0, 0)
"""The pair that every frame passes, for an interest that has words too."""
OWN: Final = "own"
ERRORS: Final = "errors"
STATE: Final = "state"
_WORDS: Final = (OWN, ERRORS, STATE)

Filters = tuple[tuple[int, int], ...]


def received(frame: CanFrame) -> int:
    """The identifier with its flags, as filters see it."""
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
    """ValueError or TypeError for an interest that no CAN bus can be asked for."""
    for each in words_of(interest):
        if each not in _WORDS:
            _pair(each)


def wants_own(interest: Sequence[Any] | None) -> bool:
    return wants(interest, OWN)


def wants(interest: Sequence[Any] | None, word: str) -> bool:
    return interest is not None and word in interest


def passes(identifier: int, filters: Iterable[tuple[int, int]] | None) -> bool:
    """`identifier` as `received` gives it."""
    return filters is None or any(identifier & mask == wanted for wanted, mask in filters)


def _pair(each: Any) -> tuple[int, int]:
    match each:
        case [int(identifier), int(mask)] if 0 <= identifier < 1 << 32 and 0 <= mask < 1 << 32:
            return identifier & mask, mask
    raise ValueError(f'{each!r} is no acceptance filter: write [identifier, mask], "own", "errors" or "state"')
