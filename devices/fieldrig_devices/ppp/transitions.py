"""The state transition table of the option negotiation automaton, as in RFC 1661 4.1.

The options of its footnotes, to restart and to wait passively for a peer, are left out.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import Final, NamedTuple


class PppState(IntEnum):
    INITIAL = 0
    STARTING = 1
    CLOSED = 2
    STOPPED = 3
    CLOSING = 4
    STOPPING = 5
    REQ_SENT = 6
    ACK_RCVD = 7
    ACK_SENT = 8
    OPENED = 9


class Event(Enum):
    UP = "Up"
    DOWN = "Down"
    OPEN = "Open"
    CLOSE = "Close"
    TIMEOUT = "TO+"
    LAST_TIMEOUT = "TO-"
    GOOD_REQUEST = "RCR+"
    BAD_REQUEST = "RCR-"
    ACK = "RCA"
    NAK_OR_REJECT = "RCN"
    TERMINATE_REQUEST = "RTR"
    TERMINATE_ACK = "RTA"
    UNKNOWN_CODE = "RUC"
    HARMLESS_REJECT = "RXJ+"
    FATAL_REJECT = "RXJ-"
    ECHO_OR_DISCARD = "RXR"


class Action(Enum):
    LAYER_UP = "tlu"
    LAYER_DOWN = "tld"
    LAYER_STARTED = "tls"
    LAYER_FINISHED = "tlf"
    INIT_COUNT = "irc"
    ZERO_COUNT = "zrc"
    SEND_REQUEST = "scr"
    SEND_ACK = "sca"
    SEND_NAK = "scn"
    SEND_TERMINATE_REQUEST = "str"
    SEND_TERMINATE_ACK = "sta"
    SEND_CODE_REJECT = "scj"
    SEND_ECHO_REPLY = "ser"


class Step(NamedTuple):
    """The effect of an event: the actions in their order, then the new state."""

    actions: tuple[Action, ...]
    state: PppState


# Event, then states 0 to 9.  A dash is a pair that cannot be.
_ROWS: Final = """
Up    2      irc,scr/6  -          -              -      -      -          -          -          -
Down  -      -          0          tls/1          0      1      1          1          1          tld/1
Open  tls/1  1          irc,scr/6  3              5      5      6          7          8          9
Close 0      tlf/0      2          2              4      4      irc,str/4  irc,str/4  irc,str/4  tld,irc,str/4
TO+   -      -          -          -              str/4  str/5  scr/6      scr/6      scr/8      -
TO-   -      -          -          -              tlf/2  tlf/3  tlf/3      tlf/3      tlf/3      -
RCR+  -      -          sta/2      irc,scr,sca/8  4      5      sca/8      sca,tlu/9  sca/8      tld,scr,sca/8
RCR-  -      -          sta/2      irc,scr,scn/6  4      5      scn/6      scn/7      scn/6      tld,scr,scn/6
RCA   -      -          sta/2      sta/3          4      5      irc/7      scr/6      irc,tlu/9  tld,scr/6
RCN   -      -          sta/2      sta/3          4      5      irc,scr/6  scr/6      irc,scr/8  tld,scr/6
RTR   -      -          sta/2      sta/3          sta/4  sta/5  sta/6      sta/6      sta/6      tld,zrc,sta/5
RTA   -      -          2          3              tlf/2  tlf/3  6          6          8          tld,scr/6
RUC   -      -          scj/2      scj/3          scj/4  scj/5  scj/6      scj/7      scj/8      scj/9
RXJ+  -      -          2          3              4      5      6          6          8          9
RXJ-  -      -          tlf/2      tlf/3          tlf/2  tlf/3  tlf/3      tlf/3      tlf/3      tld,irc,str/5
RXR   -      -          2          3              4      5      6          7          8          ser/9
"""


def _step(cell: str) -> Step:
    actions, _, state = cell.rpartition("/")
    return Step(tuple(map(Action, actions.split(","))) if actions else (), PppState(int(state)))


def _table() -> dict[tuple[PppState, Event], Step]:
    rows = [line.split() for line in _ROWS.strip().splitlines()]
    return {
        (state, Event(row[0])): _step(cell)
        for row in rows
        for state, cell in zip(PppState, row[1:], strict=True)
        if cell != "-"
    }


TRANSITIONS: Final[Mapping[tuple[PppState, Event], Step]] = _table()
