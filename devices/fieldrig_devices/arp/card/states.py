"""The states of the card, and the events that lead from one to another (manual 3.3; digest 10.1).

The table is row by row as in the digest.  The scheduler checks Enable, and its opening and closing are the events: a
blocking error while Enable is open is shown until it is closed.
"""

from collections.abc import Callable
from enum import Enum, auto
from typing import Final

from fieldrig_devices.arp.card_access import CardState

INIT, RESET_ENABLE, RESET_COMMAND = CardState.INIT, CardState.RESET_ENABLE, CardState.RESET_COMMAND
RUN, STOPPED, BLOCKED = CardState.RUN, CardState.STOPPED, CardState.BLOCKED

HELD: Final = frozenset({INIT, RESET_ENABLE, RESET_COMMAND, BLOCKED})
"""States with axes off, outputs at 0, and no running program."""


class Event(Enum):
    OPENED = auto()  # Enable
    CLOSED = auto()
    RESET = auto()  # Ctrl-F2
    STARTED = auto()  # run, from the service port or a point
    STOPPED = auto()  # stop, from the service port or a point
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
        """`on_change` is called with the previous and the new state, and may cause further events."""
        self._on_change = on_change
        self.state = INIT

    def handle(self, event: Event) -> bool:
        """Handle an event.  True if the state has changed."""
        before = self.state
        after = NEXT_STATE.get((before, event))
        if after is None:
            return False
        self.state = after
        self._on_change(before, after)
        return True
