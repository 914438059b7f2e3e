"""The settings of one end of a link: who logs in, which addresses, and the limits of time."""

from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Final, Self

from fieldrig.clock import S

UNSET: Final = IPv4Address(0)
"""The address of an end that wants to be given one (RFC 1332 3.3)."""
LONGEST_FIELD: Final = 255
"""Most bytes of a user name or a password (RFC 1334 2.2.1)."""
DEFAULT_MRU: Final = 1500
"""The size that every link takes without an agreement, in bytes (RFC 1661 6.1)."""
SMALLEST_MRU: Final = 128


@dataclass(frozen=True, slots=True)
class Login:
    """A user name and a password, in bytes as they are on the line.  ValueError for more than 255 bytes."""

    name: bytes
    password: bytes

    def __post_init__(self) -> None:
        for what, text in (("user name", self.name), ("password", self.password)):
            if len(text) > LONGEST_FIELD:
                raise ValueError(f"the {what} has {len(text)} bytes, expected at most {LONGEST_FIELD}")

    @classmethod
    def of(cls, name: str, password: str) -> Self:
        """Return the login of two texts, in UTF-8."""
        return cls(name.encode(), password.encode())

    def __repr__(self) -> str:
        return f"Login({self.name!r})"  # without the password, as this ends in logs


@dataclass(frozen=True, slots=True)
class PppSettings:
    """How one end of a link behaves; times in nanoseconds.  ValueError for an MRU out of its range."""

    demanded: Login | None = None
    """The login that the peer has to present; None demands none."""
    own: Login | None = None
    """The login that this end presents if the peer demands one; None refuses to log in."""
    local_address: IPv4Address = UNSET
    """The IP address of this end; `UNSET` asks the peer for one."""
    peer_address: IPv4Address = UNSET
    """The IP address given to the peer; `UNSET` lets the peer choose."""
    compresses_headers: bool = False
    """True to compress TCP/IP headers by RFC 1144 as far as the peer agrees, in both directions."""
    mru: int = DEFAULT_MRU
    """Longest packet that this end takes, in bytes, 128 to 1500."""
    restart_ns: int = 3 * S
    """Time until a request is repeated (RFC 1661 4.6)."""
    most_requests: int = 10
    """Requests without an answer before the link ends (RFC 1661 4.6, Max-Configure)."""
    setup_limit_ns: int = 60 * S
    """Time from the start until IP packets must pass, with all logins."""
    echo_period_ns: int = 0
    """Period of echo requests; 0 sends none."""
    most_echoes: int = 4
    """Echo requests without an answer before the link ends."""

    def __post_init__(self) -> None:
        if not SMALLEST_MRU <= self.mru <= DEFAULT_MRU:
            raise ValueError(f"the MRU is {self.mru}, expected {SMALLEST_MRU} to {DEFAULT_MRU}")
