"""The states of COM1 and of its modem, with all transitions.

Source: PacDrive manual 4634-4689 (digest PD-251 to PD-257).  The manual gives EPAS-4 and None no numbers as
values of Com1User; 0 and 3 are our choice.  Our reading is that a modem is found by its DSR, which is always on when
it is ready (PD-248).  With Auto, a port that was released is searched again only when DSR comes on, because a serial
EPAS-4 may use it.
"""

from enum import Enum, IntEnum, auto
from typing import Final


class User(IntEnum):
    """Values of Com1User."""

    EPAS_4 = 0
    MODEM = 1
    AUTO = 2
    NONE = 3


class Com1State(IntEnum):
    """Values of Com1UserState (manual table 7-4)."""

    INIT = 0
    EPAS_4 = 1
    MODEM_EPAS_4 = 2
    AUTO_SEARCH = 3
    MODEM_SEARCH = 4
    MODEM_TEST = 5
    MODEM_OFFLINE = 6
    MODEM_ONLINE = 7
    NONE = 8
    AUTO_TEST = 9
    AUTO_EPAS_4 = 10
    AUTO_OFFLINE = 11
    AUTO_ONLINE = 12


class ModemState(IntEnum):
    """Values of the parameter State of the Modem object (manual table 7-3)."""

    INIT = 0
    NO_MODEM = 1
    OFFLINE = 2
    ONLINE = 3
    INIT_STRING_OK = 4
    INIT_STRING_ERROR = 5
    INIT_STRING_TIMEOUT = 6
    EXP_INIT_STRING_OK = 7
    EXP_INIT_STRING_ERROR = 8
    EXP_INIT_STRING_TIMEOUT = 9


USER_WORDS: Final = {0: "EPAS-4", 1: "modem", 2: "automatic", 3: "none"}
STATE_WORDS: Final = {
    0: "checks the line",
    1: "EPAS-4",
    2: "no modem, or it refused a string: EPAS-4",
    3: "looks for a modem",
    4: "looks for a modem",
    5: "initialises the modem",
    6: "modem ready",
    7: "in a call",
    8: "no user",
    9: "initialises the modem",
    10: "no modem, or it refused a string: EPAS-4",
    11: "modem ready",
    12: "in a call",
}
MODEM_WORDS: Final = {
    0: "being checked",
    1: "no modem",
    2: "waits for a call",
    3: "in a call",
    4: "InitString accepted",
    5: "InitString refused",
    6: "no answer to InitString",
    7: "ExpInitString accepted",
    8: "ExpInitString refused",
    9: "no answer to ExpInitString",
}


class Event(Enum):
    """An event at the port."""

    MODEM_CHOSEN = auto()
    """The line has been cleared, and Com1User is Modem."""
    AUTO_CHOSEN = auto()
    """The line has been cleared, and Com1User is Auto."""
    NOTHING_FOUND = auto()
    SEARCH_DUE = auto()
    READY = auto()
    """DSR of the modem is on."""
    GONE = auto()
    """DSR of the modem has gone off."""
    INITIALISED = auto()
    REFUSED = auto()
    """An init string was answered with ERROR, or not at all."""
    CALL = auto()
    CALL_ENDED = auto()


# Manual table 7-4, row by row.  An event that is not listed changes nothing.
NEXT: Final = {
    (Com1State.INIT, Event.MODEM_CHOSEN): Com1State.MODEM_SEARCH,
    (Com1State.INIT, Event.AUTO_CHOSEN): Com1State.AUTO_SEARCH,
    (Com1State.MODEM_SEARCH, Event.READY): Com1State.MODEM_TEST,
    (Com1State.MODEM_SEARCH, Event.NOTHING_FOUND): Com1State.MODEM_EPAS_4,
    (Com1State.MODEM_EPAS_4, Event.SEARCH_DUE): Com1State.MODEM_SEARCH,
    (Com1State.MODEM_EPAS_4, Event.READY): Com1State.MODEM_TEST,
    (Com1State.MODEM_TEST, Event.INITIALISED): Com1State.MODEM_OFFLINE,
    (Com1State.MODEM_TEST, Event.REFUSED): Com1State.MODEM_EPAS_4,
    (Com1State.MODEM_TEST, Event.GONE): Com1State.MODEM_SEARCH,
    (Com1State.MODEM_OFFLINE, Event.CALL): Com1State.MODEM_ONLINE,
    (Com1State.MODEM_OFFLINE, Event.GONE): Com1State.MODEM_SEARCH,
    (Com1State.MODEM_ONLINE, Event.CALL_ENDED): Com1State.MODEM_OFFLINE,
    (Com1State.MODEM_ONLINE, Event.GONE): Com1State.MODEM_SEARCH,
    (Com1State.AUTO_SEARCH, Event.READY): Com1State.AUTO_TEST,
    (Com1State.AUTO_SEARCH, Event.NOTHING_FOUND): Com1State.AUTO_EPAS_4,
    (Com1State.AUTO_EPAS_4, Event.READY): Com1State.AUTO_TEST,
    (Com1State.AUTO_TEST, Event.INITIALISED): Com1State.AUTO_OFFLINE,
    (Com1State.AUTO_TEST, Event.REFUSED): Com1State.AUTO_EPAS_4,
    (Com1State.AUTO_TEST, Event.GONE): Com1State.AUTO_SEARCH,
    (Com1State.AUTO_OFFLINE, Event.CALL): Com1State.AUTO_ONLINE,
    (Com1State.AUTO_OFFLINE, Event.GONE): Com1State.AUTO_SEARCH,
    (Com1State.AUTO_ONLINE, Event.CALL_ENDED): Com1State.AUTO_OFFLINE,
    (Com1State.AUTO_ONLINE, Event.GONE): Com1State.AUTO_SEARCH,
}

SEARCHING: Final = (Com1State.MODEM_SEARCH, Com1State.AUTO_SEARCH)
RELEASED: Final = (Com1State.MODEM_EPAS_4, Com1State.AUTO_EPAS_4)
TESTING: Final = (Com1State.MODEM_TEST, Com1State.AUTO_TEST)
OFFLINE: Final = (Com1State.MODEM_OFFLINE, Com1State.AUTO_OFFLINE)
ONLINE: Final = (Com1State.MODEM_ONLINE, Com1State.AUTO_ONLINE)
CHOSEN: Final = {User.MODEM: Event.MODEM_CHOSEN, User.AUTO: Event.AUTO_CHOSEN}
RELEASED_TO: Final = {
    User.EPAS_4: Com1State.EPAS_4,
    User.NONE: Com1State.NONE,
    User.MODEM: Com1State.MODEM_EPAS_4,
    User.AUTO: Com1State.AUTO_EPAS_4,
}
"""The state in which no modem is looked for, for lack of a Modem object or because of the value."""
