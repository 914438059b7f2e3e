"""The states of the card, and what leads from one to another (manual 3.3; digest 10.1).

The table stands row by row as in the digest.  Enable is looked at by the scheduler, and what counts is that it opened
or closed: a blocking error while it is open shows until it is closed.
"""

from collections.abc import Callable
from enum import Enum, auto
from typing import Final

from fieldrig_devices.arp.outside import CardState

INIT, RESET_ENABLE, RESET_COMMAND = CardState.INIT, CardState.RESET_ENABLE, CardState.RESET_COMMAND
RUN, STOPPED, BLOCKED = CardState.RUN, CardState.STOPPED, CardState.BLOCKED

HELD: Final = frozenset({INIT, RESET_ENABLE, RESET_COMMAND, BLOCKED})
"""Axes off, outputs 0, no program."""


class Event(Enum):
    OPENED = auto()  # Enable
    CLOSED = auto()
    RESET = auto()  # Ctrl-F2
    STARTED = auto()  # run, from the service port or a point
    STOPPED = auto()  # stop, from there
    ENDED = auto()  # END of the main program
    FAILED = auto()  # a blocking error


# Digest 10.1.  A pair that is not listed changes nothing.
NEXT_STATE: Final = {
    (INIT, Event.OPENED): RESET_ENABLE,
    (INIT, Event.CLOSED): RUN,
    **{(state, Event.OPENED): RESET_ENABLE for state in (RESET_COMMAND, RUN, STOPPED, BLOCKED)},
    (RESET_ENABLE, Event.CLOSED): RUN,
    (BLOCKED, Event.CLOSED): RUN,  # if Enable was open when it blocked
    **{(state, Event.RESET): RESET_COMMAND for state in (RUN, STOPPED, BLOCKED)},
    (RESET_COMMAND, Event.STARTED): RUN,
    (STOPPED, Event.STARTED): RUN,
    (RUN, Event.STOPPED): STOPPED,
    (RUN, Event.ENDED): STOPPED,
    **{(state, Event.FAILED): BLOCKED for state in CardState if state is not BLOCKED},
}


class States:
    def __init__(self, on_change: Callable[[CardState, CardState], None]) -> None:
        """`on_change` gets the state before and the new one, and may bring about further events."""
        self._on_change = on_change
        self.state = INIT

    def handle(self, event: Event) -> bool:
        """Whether it led to another state."""
        before = self.state
        after = NEXT_STATE.get((before, event))
        if after is None:
            return False
        self.state = after
        self._on_change(before, after)
        return True
