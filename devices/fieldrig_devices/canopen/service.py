"""What the node's communication is made of: the NMT states, the services each allows, and the services' one contract.

Source: CiA 301 chapter 7.3.2, table 'NMT states and communication objects'.
"""

from enum import Enum, IntEnum, auto


class State(IntEnum):
    """As in the heartbeat; initialisation has no code of its own, the boot-up message carries 0."""

    INITIALISING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class Object(Enum):
    """Communication objects."""

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
    State.INITIALISING: frozenset({Object.LSS}),  # a node without a node-ID waits here for one
    State.PRE_OPERATIONAL: _CONFIGURED,
    State.OPERATIONAL: _CONFIGURED | {Object.PDO},
    State.STOPPED: _ALWAYS,
}


class Reset(Enum):
    NODE = auto()
    """Power-on and 'reset node': everything is as new."""
    COMMUNICATION = auto()
    """'Reset communication': the parameters 1000h to 1FFFh are."""


class Service:
    """One service of the node.  It connects to its parameters when built, and acts from the first reset on.

    Of what is not allowed in a state, nothing arrives (the port sees to it); what a service sends by itself
    it stops when the state is entered.
    """

    def reset(self, scope: Reset) -> None:
        """The parameters are at their power-on values: forget what was under way, listen anew."""

    def enter(self, state: State) -> None:
        """The NMT state has changed, or communication was reset to it."""

    def on_communication_error(self, is_lost: bool) -> None:
        """A node that is watched is lost, or the node is in bus-off; or that is over."""
