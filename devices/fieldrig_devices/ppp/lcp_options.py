"""The options of LCP (RFC 1661 chapter 6, RFC 1662 chapter 7), of this end and of the peer.

Known are MRU, control character map, authentication by PAP, magic number and the two compressions; all others are
rejected.  CHAP is answered with the proposal of PAP: the controller understands only a plain password (PD-259).
"""

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Final

from fieldrig_devices.ppp.framing import ALL_CONTROLS
from fieldrig_devices.ppp.packets import Option
from fieldrig_devices.ppp.phases import End
from fieldrig_devices.ppp.protocols import ProtocolNumber
from fieldrig_devices.ppp.settings import DEFAULT_MRU, SMALLEST_MRU, PppSettings

MOST_LOOPS: Final = 5
"""Requests in a row with our own magic number before the line counts as looped back (RFC 1661 6.4)."""


class Kind(IntEnum):
    MRU = 1
    ACCM = 2
    AUTHENTICATION = 3
    MAGIC = 5
    SHORT_PROTOCOL = 7
    SHORT_HEADER = 8


PAP_OPTION: Final = Option(Kind.AUTHENTICATION, ProtocolNumber.PAP.to_bytes(2, "big"))
FLAGS: Final = (Kind.SHORT_PROTOCOL, Kind.SHORT_HEADER)


def number_option(option_type: int, value: int, length: int) -> Option:
    return Option(option_type, value.to_bytes(length, "big"))


class LcpOptions:
    """The options that this end asks for, and those granted to the peer, since the last `begin`."""

    def __init__(self, settings: PppSettings, new_magic: Callable[[], int]) -> None:
        self._settings, self._new_magic = settings, new_magic
        self._loops = 0
        self.refusal: End | None = None
        """The reason why no agreement is possible."""
        self.magic = 0
        self._wanted: set[int] = set()
        self._accm, self._mru = 0, settings.mru
        self.agree([])

    def begin(self) -> None:
        self.magic = self._nonzero_magic()
        self._wanted = {Kind.ACCM, Kind.MAGIC, *FLAGS}
        if self._settings.mru != DEFAULT_MRU:
            self._wanted.add(Kind.MRU)
        if self._settings.demanded is not None:
            self._wanted.add(Kind.AUTHENTICATION)
        self._accm, self._mru = 0, self._settings.mru  # a hardware handshake needs no characters
        self.agree([])

    # Of this end.

    def request(self) -> Sequence[Option]:
        values = {
            Kind.MRU: number_option(Kind.MRU, self._mru, 2),
            Kind.ACCM: number_option(Kind.ACCM, self._accm, 4),
            Kind.AUTHENTICATION: PAP_OPTION,
            Kind.MAGIC: number_option(Kind.MAGIC, self.magic, 4),
            Kind.SHORT_PROTOCOL: Option(Kind.SHORT_PROTOCOL),
            Kind.SHORT_HEADER: Option(Kind.SHORT_HEADER),
        }
        return [option for option_type, option in values.items() if option_type in self._wanted]

    @property
    def accm(self) -> int:
        """The control characters that the peer escapes, once the layer is open."""
        return self._accm if Kind.ACCM in self._wanted else ALL_CONTROLS

    @property
    def own_magic(self) -> int:
        """The number for echo packets: 0 unless the magic number was agreed."""
        return self.magic if Kind.MAGIC in self._wanted else 0

    def on_nak(self, option: Option) -> None:
        value = int.from_bytes(option.data, "big")
        if option.kind == Kind.MRU and len(option.data) == 2 and SMALLEST_MRU <= value <= DEFAULT_MRU:
            self._mru = value
        elif option.kind == Kind.ACCM and len(option.data) == 4:
            self._accm |= value
        elif option.kind == Kind.MAGIC:
            self.magic = self._nonzero_magic()
        elif option.kind in (*FLAGS, Kind.MRU, Kind.ACCM):
            self.on_reject(option)

    def on_reject(self, option: Option) -> None:
        if option.kind == Kind.AUTHENTICATION and Kind.AUTHENTICATION in self._wanted:
            self.refusal = End.LOOPED_BACK if self._loops else End.NO_AUTHENTICATION
        else:
            self._wanted -= {option.kind}

    # Of the peer.

    def judge(self, option: Option) -> Option | None:
        if option.kind == Kind.AUTHENTICATION:
            return PAP_OPTION if self._settings.own is not None else None
        value = int.from_bytes(option.data, "big")
        if option.kind == Kind.MAGIC:
            return self._judge_magic(option, value)
        if option.kind == Kind.MRU:
            return (
                option if len(option.data) == 2 and value >= SMALLEST_MRU else number_option(Kind.MRU, DEFAULT_MRU, 2)
            )
        if option.kind == Kind.ACCM:
            return option if len(option.data) == 4 else number_option(Kind.ACCM, 0, 4)
        return Option(option.kind) if option.kind in FLAGS else None

    def _judge_magic(self, option: Option, value: int) -> Option:
        is_ours = len(option.data) == 4 and value == self.own_magic
        self._loops = self._loops + 1 if is_ours else 0
        if self._loops >= MOST_LOOPS:
            self.refusal = End.LOOPED_BACK
        if is_ours or value == 0 or len(option.data) != 4:
            return number_option(Kind.MAGIC, self._nonzero_magic(), 4)
        return option

    def missing(self, options: Sequence[Option]) -> Sequence[Option]:
        return ()

    def agree(self, options: Sequence[Option]) -> None:
        granted = {option.kind: int.from_bytes(option.data, "big") for option in options}
        self.peer_mru = granted.get(Kind.MRU, DEFAULT_MRU)
        self.peer_accm = granted.get(Kind.ACCM, ALL_CONTROLS)
        self.must_log_in = Kind.AUTHENTICATION in granted
        self.has_short_protocol = Kind.SHORT_PROTOCOL in granted
        self.has_short_header = Kind.SHORT_HEADER in granted

    def _nonzero_magic(self) -> int:
        return self._new_magic() & 0xFFFFFFFF or 1
