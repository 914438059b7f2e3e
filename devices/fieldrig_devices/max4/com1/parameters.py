"""The parameters of COM1: Com1User and Com1UserState of the controller, and the seven of the Modem object.

Source: PacDrive manual 4585-4689 (digest PD-247 to PD-257).  UserName and Password have no default in the manual; while
either is empty, no caller can log in (our choice).
"""

from collections.abc import Callable, Sequence
from ipaddress import AddressValueError, IPv4Address
from typing import Final, Protocol

from fieldrig.device import Value
from fieldrig_devices.max4.com1.states import MODEM_WORDS, STATE_WORDS, USER_WORDS, Com1State, ModemState, User
from fieldrig_devices.max4.configuration.tree import Access, ObjectTree, Parameter, Type

REMOTE_IP_ADDRESS: Final = "190.200.100.101"
LOCAL_IP_ADDRESS: Final = "190.200.100.100"
INIT_STRING: Final = "AT&F E0 Q0 V1 &S0 &C1 &R0 S0=2"
EXP_INIT_STRING: Final = "AT +MS=,0"
LONGEST_STRING: Final = 40


class Port(Protocol):
    """COM1, as its parameters see it."""

    @property
    def state(self) -> Com1State: ...

    @property
    def modem_state(self) -> ModemState: ...

    def user_written(self, user: Parameter) -> None:
        """Com1User has been written, in the tree of this parameter."""


class Com1Parameters:
    """The parameters in one tree."""

    def __init__(self, tree: ObjectTree, modems: Sequence[str], port: Port) -> None:
        """`modems` has the symbolic name of the Modem object, if there is one."""
        general = tree.root.group("General")
        numbers = tuple(map(int, User))
        self.user = general.add(
            Parameter(
                "Com1User",
                Type.UINT,
                Access.INPUT_INIT,
                int(User.EPAS_4),
                only=numbers,
                about="user of COM1: 0 EPAS-4, 1 modem, 2 automatic, 3 none",
                words=USER_WORDS,
            )
        )
        self.user.watcher = lambda _: port.user_written(self.user)
        general.add(
            Parameter(
                "Com1UserState", Type.UINT, read=lambda: int(port.state), about="state of COM1", words=STATE_WORDS
            )
        )
        self.modem = _Modem(tree, modems[0], port) if modems else None


class _Modem:
    """The parameters of the Modem object."""

    def __init__(self, tree: ObjectTree, symbol: str, port: Port) -> None:
        general = tree.root.add("Modem", "MODEM", symbol).group("General")

        def text(
            name: str, first: str, about: str, check: Callable[[Value], str], *, secret: bool = False
        ) -> Parameter:
            parameter = Parameter(
                name, Type.STRING, Access.INPUT_INIT, first, high=LONGEST_STRING, about=about, is_secret=secret,
                write=lambda value: parameter.put(check(value)),
            )  # fmt: skip
            return general.add(parameter)

        self.remote = text("RemoteIpAddress", REMOTE_IP_ADDRESS, "address that the caller gets", _address)
        self.local = general.add(
            Parameter("LocalIpAddress", Type.STRING, read=lambda: LOCAL_IP_ADDRESS, about="address of the controller")
        )
        self.user_name = text("UserName", "", "name that a caller logs in with", str)
        self.password = text("Password", "", "password that a caller logs in with", str, secret=True)
        self.init_string = text("InitString", INIT_STRING, "first AT commands for the modem", _printable)
        self.exp_init_string = text("ExpInitString", EXP_INIT_STRING, "further AT commands", _command)
        general.add(
            Parameter(
                "State", Type.UINT, read=lambda: int(port.modem_state), about="state of the modem", words=MODEM_WORDS
            )
        )


def _address(value: Value) -> str:
    try:
        return str(IPv4Address(str(value)))
    except AddressValueError:
        raise ValueError(f"RemoteIpAddress: expected an address such as {REMOTE_IP_ADDRESS}, got {value!r}") from None


def _printable(value: Value) -> str:
    text = str(value)
    if not (text.isascii() and text.isprintable()):
        raise ValueError(f"expected AT commands in printable ASCII, got {text!r}")
    return text


def _command(value: Value) -> str:
    text = _printable(value)
    if not text.upper().startswith("AT"):
        raise ValueError(f"ExpInitString: expected AT and commands such as {EXP_INIT_STRING}, got {text!r}")
    return text
