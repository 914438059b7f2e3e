"""Telnet as a function of bytes: it separates commands from data (RFC 854) and negotiates options (RFC 1143 in short).

Data are always binary: CR is a plain byte, and so are NUL and LF after it (RFC 856).  A client that did not agree to
BINARY is treated in the same way, as serial servers do.
Left out: urgent data, and every command that does not concern an option.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

# RFC 854, the table of commands
SE, SB, WILL, WONT, DO, DONT, IAC = 240, 250, 251, 252, 253, 254, 255
BINARY = 0  # RFC 856
ECHO = 1  # RFC 857
SUPPRESS_GO_AHEAD = 3  # RFC 858

LONGEST_COMMAND = 1024
"""Longest subnegotiation, in bytes; a longer one is skipped up to its end."""

_END = bytes((IAC, SE))


class Negotiation(NamedTuple):
    command: int
    option: int


class Subnegotiation(NamedTuple):
    option: int
    body: bytes


Event = bytes | Negotiation | Subnegotiation


def escape(data: bytes) -> bytes:
    """Data as Telnet carries it, with IAC doubled."""
    return data.replace(b"\xff", b"\xff\xff") if IAC in data else data


def subnegotiation(option: int, body: bytes) -> bytes:
    return bytes((IAC, SB, option)) + escape(body) + _END


class TelnetReader:
    """Parses bytes as they arrive, in pieces of any size; no input is an error."""

    def __init__(self) -> None:
        self._held = b""  # a command whose end has not arrived
        self._is_skipping = False  # within a subnegotiation that is too long

    def feed(self, data: bytes) -> Iterator[Event]:
        if not self._held and not self._is_skipping and IAC not in data:
            yield data
            return
        data, self._held = self._held + data, b""
        if self._is_skipping:
            data = self._skip(data)
        text = bytearray()
        at = 0
        while (escape := data.find(IAC, at)) >= 0:
            text += data[at:escape]
            event, at = _command(data, escape)
            if at < 0:
                self._hold(data[escape:])
                at = len(data)
            elif event is _LITERAL_IAC:
                text.append(IAC)
            elif event is not None:
                if text:
                    yield bytes(text)
                    text.clear()
                yield event
        text += data[at:]
        if text:
            yield bytes(text)

    def _hold(self, command: bytes) -> None:
        if len(command) > LONGEST_COMMAND:
            self._is_skipping = True
            command = command[-1:] if command[-1] == IAC else b""
        self._held = command

    def _skip(self, data: bytes) -> bytes:
        """The data after the end of a subnegotiation that is too long; an IAC at the very end is held."""
        at = 0
        while 0 <= (at := data.find(IAC, at)) < len(data) - 1:
            if data[at + 1] == SE:
                self._is_skipping = False
                return data[at + 2 :]
            at += 2
        self._held = data[at:] if at >= 0 else b""
        return b""


_LITERAL_IAC = Negotiation(IAC, IAC)
_UNFINISHED = (None, -1)


def _command(data: bytes, at: int) -> tuple[Negotiation | Subnegotiation | None, int]:
    """The command whose IAC is at `at` (None: it is ignored), and its end (-1: it has not arrived)."""
    if at + 1 == len(data):
        return _UNFINISHED
    code = data[at + 1]
    if code == IAC:
        return _LITERAL_IAC, at + 2
    if WILL <= code <= DONT:
        return (Negotiation(code, data[at + 2]), at + 3) if at + 2 < len(data) else _UNFINISHED
    if code == SB:
        return _subnegotiation(data, at + 2)
    return None, at + 2


def _subnegotiation(data: bytes, start: int) -> tuple[Subnegotiation | None, int]:
    at = start
    while 0 <= (at := data.find(IAC, at)) < len(data) - 1:
        if data[at + 1] == SE:
            body = data[start:at].replace(b"\xff\xff", b"\xff")
            return (Subnegotiation(body[0], body[1:]) if body else None), at + 2
        if data[at + 1] != IAC:
            return None, at  # RFC 855 allows no command here: give the subnegotiation up and execute the command
        at += 2
    return _UNFINISHED


class Options:
    """The options that are in force, and the answers that agree on more.  No request is sent twice."""

    def __init__(self, ours: frozenset[int], theirs: frozenset[int], write: Callable[[bytes], None]) -> None:
        self._write = write
        # WILL of one side corresponds to DO of the other: by the command with which the other side agrees
        self._allowed = {DO: ours, WILL: theirs}
        self._asked: dict[int, set[int]] = {DO: set(), WILL: set()}
        self.in_force: dict[int, set[int]] = {DO: set(), WILL: set()}

    def ask(self, agreement: int, option: int) -> None:
        """Request an option; the other side agrees with `agreement` (DO or WILL)."""
        self._asked[agreement].add(option)
        self._write(bytes((IAC, _YES[agreement], option)))

    def negotiate(self, command: int, option: int) -> bool:
        """Answer a command as RFC 1143 says.  True if the option comes into force with it."""
        agreement = _AGREEMENT[command]
        in_force, asked = self.in_force[agreement], self._asked[agreement]
        was_asked = option in asked
        asked.discard(option)
        if command != agreement:  # a refusal
            if option in in_force:
                in_force.discard(option)
                self._write(bytes((IAC, _NO[agreement], option)))
            return False
        if option in in_force:
            return False
        if option not in self._allowed[agreement]:
            self._write(bytes((IAC, _NO[agreement], option)))
            return False
        in_force.add(option)
        if not was_asked:
            self._write(bytes((IAC, _YES[agreement], option)))
        return True


_AGREEMENT = {DO: DO, DONT: DO, WILL: WILL, WONT: WILL}
_YES = {DO: WILL, WILL: DO}
_NO = {DO: WONT, WILL: DONT}
