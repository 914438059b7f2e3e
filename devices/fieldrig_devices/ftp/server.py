"""FTP on one control connection, as a function of bytes and time.

Source: RFC 959, RFC 1123 chapter 4.1, RFC 2389, RFC 2428, RFC 2577, RFC 3659.  A data connection to the client goes to
no other address than its own.  Files are sent as they are, also with TYPE A.  A file that is written behind a restart
ends with the last byte that arrives.
Left out: folders, dates, unique names (STOU), TLS.

No library does this: those that are kept well (pyftpdlib, aioftp) own their sockets and event loop, while these
sessions run over a stack of our own as well, and in virtual time.
"""

import re
from collections import deque
from functools import partial
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig_bus.browsers import is_request
from fieldrig_devices.connections.connection import TOO_LONG, UNREAD, Connection, Serve
from fieldrig_devices.ftp.commands import Command, FileCommands
from fieldrig_devices.ftp.files import Files
from fieldrig_devices.ftp.listing import FACTS
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.ftp.replies import Reply, lines_of, printable
from fieldrig_devices.ftp.transfer import DataPort

LONGEST_LINE: Final = 1024
MOST_LINES: Final = 64
"""Commands that may wait: for a transfer that is under way, for the port of a PASV, or while a login is delayed."""
MOST_UNSENT: Final = 64 * 1024
IDLE_NS: Final = 300 * S
MOST_FAILURES: Final = 3
"""Failed logins after which a connection is closed."""
FEATURES: Final = (
    "EPRT", "EPSV", "MDTM", "PASV", "REST STREAM", "SIZE", "TVFS", "UTF8",
)  # fmt: skip
HELP_COLUMNS: Final = 8
TOO_MANY_LINES: Final = "clients with too many commands that wait"
TOO_MANY_FAILURES: Final = "clients with too many failed logins"
TELNET: Final = re.compile(rb"\xff(?:[\xf0-\xfa]|[\xfb-\xfe].)", re.DOTALL)
"""Commands of Telnet among those of FTP (RFC 959, 4.1.3: before ABOR): a signal, or an option that is offered."""
REST_OF_SIGNAL: Final = re.compile(rb"^[\x80-\xff]+")
"""A data mark of which one byte was urgent data: FFh is left of it, or F2h if the client is one of BSD."""


def serving(clock: Clock, files: Files, login: FtpLogin) -> Serve:
    """Return the service for these files."""
    return lambda connection: FtpSession(clock, connection, files, login)


class FtpSession:
    """One control connection."""

    def __init__(self, clock: Clock, connection: Connection, files: Files, login: FtpLogin) -> None:
        self._clock, self._connection, self._files, self._login = clock, connection, files, login
        self._data = DataPort(clock, self._on_transfer)
        self._partial = b""
        self._lines: deque[bytes] = deque()
        self._user_name: str | None = None
        self._is_logged_in = self._is_closed = self._is_running = False
        self._failures = 0
        self._idle = Alarm(self._clock)
        self._delay = Alarm(self._clock)
        self._free: dict[str, Command] = {
            "USER": self._user,
            "PASS": self._pass,
            "QUIT": self._quit,
            "SYST": lambda _: self._reply(Reply.SYSTEM),
            "FEAT": lambda _: self._features(),
            "NOOP": lambda _: self._reply(Reply.OKAY),
            "OPTS": self._options,
            "HELP": self._help,
            "REIN": self._reinitialize,
        }
        self._commands = FileCommands(connection, files, self._data, self._reply, self._run)
        self._reply(Reply.READY)
        self._wait()

    # ---- events

    def received(self, data: bytes) -> None:
        if self._is_closed:
            return
        *lines, self._partial = (self._partial + data).split(b"\n")
        self._lines += lines
        if len(self._partial) > LONGEST_LINE:
            self._close(Reply.TOO_LONG, TOO_LONG)
            return
        self._run()
        if len(self._lines) > MOST_LINES:
            self._close(Reply.CLOSING, TOO_MANY_LINES)

    def drained(self) -> None: ...

    def ended(self) -> None:
        """End with the client; a file that has not arrived completely by then is dropped."""
        if not self._is_closed:
            self._end()
            self._connection.close()

    def lost(self) -> None:
        self._end()

    # ---- commands

    def _run(self) -> None:
        """Carry out the commands that have arrived, one after the other: a client may send several without waiting."""
        if self._is_running:  # a command has ended its transfer at once
            return
        self._is_running = True
        while self._lines and not self._delay.is_set and not self._is_closed and self._is_free():
            self._wait()
            self._on_line(self._lines.popleft())
        self._is_running = False

    def _is_free(self) -> bool:
        """True if the next command need not wait: during a transfer only ABOR and STAT do not (RFC 959, 4.1.3)."""
        if self._commands.is_opening:
            return False
        if self._data.is_busy and any(_command(line)[0] == "ABOR" for line in self._lines):
            self._commands.abort_transfer()
        return not self._data.is_busy or _command(self._lines[0])[0] == "STAT"

    def _on_transfer(self, reply: str) -> None:
        self._reply(reply)
        self._run()

    def _on_line(self, line: bytes) -> None:
        if len(line) > LONGEST_LINE:
            self._reply(Reply.TOO_LONG)
            return
        verb, argument = _command(line)
        if is_request(_plain(line)):  # a browser that was sent here by some page (`browsers`), as vsftpd does
            self._close(Reply.UNKNOWN)
            return
        if verb != "RNTO":
            self._commands.forget_name()
        if verb in self._free:
            self._free[verb](argument)
        elif verb not in self._commands and verb not in NOT_IMPLEMENTED:
            self._reply(Reply.UNKNOWN)
        elif not self._is_logged_in:
            self._reply(Reply.NOT_LOGGED_IN)
        elif verb in NOT_IMPLEMENTED:
            self._reply(Reply.NOT_IMPLEMENTED)
        else:
            self._commands.run(verb, argument)

    def _user(self, name: str) -> None:
        self._is_logged_in = False
        self._commands.reset()
        self._user_name = name
        self._reply(Reply.NEED_PASSWORD)

    def _pass(self, password: str) -> None:
        name, self._user_name = self._user_name, None
        if name is None:
            self._reply(Reply.WRONG_ORDER)
            return
        is_right = self._login.is_right(name, password)
        delay_ns = 0 if is_right else self._login.delay_ns
        if delay_ns:
            self._delay.after(delay_ns, partial(self._answer_login, is_right))
        else:
            self._answer_login(is_right)

    def _answer_login(self, is_right: bool) -> None:
        self._is_logged_in = is_right
        self._failures += not is_right
        if is_right:
            self._reply(Reply.LOGGED_IN)
        elif self._failures < MOST_FAILURES:
            self._reply(Reply.LOGIN_REFUSED)
        else:
            self._close(Reply.CLOSING, TOO_MANY_FAILURES)
        self._run()

    def _quit(self, _argument: str) -> None:
        self._close(Reply.GOODBYE)

    def _features(self) -> None:
        chosen = "".join(f"{fact}{'*' if fact in self._commands.facts else ''};" for fact in FACTS)
        self._reply(lines_of(211, "Extensions supported:", [*FEATURES, f"MLST {chosen}"], "End"))

    def _options(self, argument: str) -> None:
        command, _, rest = argument.partition(" ")
        if command.upper() == "MLST":
            self._commands.choose_facts(rest)
            return
        is_known = argument.upper() in ("UTF8 ON", "UTF8", "UTF-8 ON")
        self._reply(Reply.OKAY if is_known else Reply.WRONG_ARGUMENT)

    def _help(self, argument: str) -> None:
        verb = argument.strip().upper()
        verbs = sorted((*self._free, *self._commands.verbs))
        if not verb:
            rows = [" ".join(verbs[at : at + HELP_COLUMNS]) for at in range(0, len(verbs), HELP_COLUMNS)]
            self._reply(lines_of(214, "These commands are implemented:", rows, "End"))
        elif ALIASES.get(verb, verb) in verbs:
            self._reply(f"214 {printable(verb)} is implemented as in RFC 959 and its extensions.")
        else:
            self._reply(Reply.NOT_IMPLEMENTED)

    def _reinitialize(self, _argument: str) -> None:
        """Begin again as after the connection (RFC 959, 4.1.1)."""
        self._user_name, self._is_logged_in = None, False
        self._commands.reset()
        self._commands.facts = FACTS
        self._reply(Reply.READY)

    # ---- replies and the end

    def _reply(self, text: str) -> None:
        if not self._is_closed:
            self._connection.write(f"{text}\r\n".encode("utf-8", "replace"))
            if self._connection.unsent > MOST_UNSENT:
                self._end()
                self._connection.cut(UNREAD)

    def _wait(self) -> None:
        self._idle.after(IDLE_NS, self._on_idle)

    def _on_idle(self) -> None:
        if self._data.is_busy:
            self._wait()
        else:
            self._close(Reply.CLOSING)

    def _close(self, reply: str, limit: str = "") -> None:
        """Send a reply and close the connection; `limit` names the limit that the client has reached."""
        self._reply(reply)
        if self._is_closed:
            return
        self._end()
        if limit:
            self._connection.cut(limit)
        else:
            self._connection.close()

    def _end(self) -> None:
        self._is_closed = True
        self._data.abort()
        self._idle.stop()
        self._delay.stop()


def _plain(line: bytes) -> bytes:
    return REST_OF_SIGNAL.sub(b"", TELNET.sub(b"", line))


def _command(line: bytes) -> tuple[str, str]:
    """Return the verb of a line, and what follows it."""
    word, _, argument = _plain(line).decode("utf-8", "replace").strip("\r\n").partition(" ")
    verb = word.upper()
    return ALIASES.get(verb, verb), argument


ALIASES: Final = {"XPWD": "PWD", "XCWD": "CWD", "XCUP": "CDUP", "XMKD": "MKD", "XRMD": "RMD"}
"""RFC 1123, 4.1.3.1."""
NOT_IMPLEMENTED: Final = frozenset(("STOU", "SMNT", "SITE", "AUTH", "PBSZ", "PROT"))
"""Commands that the server knows and refuses with 502."""
