"""The NMT states, the communication objects that each state allows, and the contract of all services of a node.

Source: CiA 301 chapter 7.3.2, table 'NMT states and communication objects'.
"""

from enum import Enum, IntEnum, auto


class State(IntEnum):
    """NMT states with their heartbeat codes; 'initialising' has the 0 of the boot-up message."""

    INITIALISING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class Object(Enum):
    """Communication objects, in the sense of CiA 301."""

    PDO = auto()
    SDO = auto()
    SYNC = auto()
    TIME = auto()
    EMCY = auto()
    NMT = auto()
    ERROR_CONTROL = auto()
    LSS = auto()


_ALWAYS = frozenset({Object.NMT, Object.ERROR_CONTROL, Object.LSS})
_CONFIGURED = _ALWAYS | {Object.SDO, Object.SYNC, Object.TIME, Object.EMCY}

ALLOWED: dict[State, frozenset[Object]] = {
    State.INITIALISING: frozenset({Object.LSS}),  # an unconfigured node waits here for its node-ID
    State.PRE_OPERATIONAL: _CONFIGURED,
    State.OPERATIONAL: _CONFIGURED | {Object.PDO},
    State.STOPPED: _ALWAYS,
}


class Reset(Enum):
    NODE = auto()
    """Power-on and 'reset node': all objects take their power-on values."""
    COMMUNICATION = auto()
    """'Reset communication': objects 1000h to 1FFFh take their power-on values."""


class Service:
    """One service of the node.  It connects to its parameters when it is built, and works from the first reset on.

    The port drops frames that the NMT state doesn't allow; a service stops what it sends by itself in `enter`.
    """

    def reset(self, scope: Reset) -> None:
        """Drop all activity and listen again; the parameters have taken their power-on values."""

    def enter(self, state: State) -> None:
        """Handle a new NMT state; also called with the same state after a reset of communication."""

    def on_communication_error(self, is_lost: bool) -> None:
        """Handle the loss of a monitored node or bus-off (`is_lost`), or its end."""
