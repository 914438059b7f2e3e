"""The commands of FTP after the login: files, their transfer, and the parameters of a transfer.

Source: RFC 959, 4.1; RFC 2428; RFC 3659.
"""

import re
from collections.abc import Callable
from functools import partial
from ipaddress import IPv4Address
from typing import Final

from fieldrig_devices.connections.connection import Connection, Session
from fieldrig_devices.ftp import addresses, listing
from fieldrig_devices.ftp.addresses import Address, FamilyError
from fieldrig_devices.ftp.files import Files
from fieldrig_devices.ftp.jobs import (
    ForbiddenNameError,
    RestartError,
    Send,
    Store,
    beginning_of,
    content_of,
    rest_of,
)
from fieldrig_devices.ftp.replies import Reply, lines_of, refused
from fieldrig_devices.ftp.transfer import DataPort, Job

Command = Callable[[str], None]
HIGHEST_RESTART = (1 << 63) - 1
NEED_ARGUMENT: Final = frozenset(
    ("ACCT", "ALLO", "APPE", "CWD", "DELE", "MDTM", "MKD", "MODE", "RETR", "RMD", "RNFR", "RNTO", "SIZE", "STOR",
     "STRU", "TYPE")
)  # fmt: skip
"""Commands that mean nothing without their argument (RFC 959, 5.3.1)."""
SPACE: Final = re.compile(r"[0-9]+(?: R [0-9]+)?", re.IGNORECASE)
"""The argument of ALLO: bytes, and perhaps the size of a record."""


class FileCommands:
    """The commands of one control connection, by their verbs."""

    def __init__(
        self,
        connection: Connection,
        files: Files,
        data: DataPort,
        reply: Callable[[str], None],
        on_port: Callable[[], None],
    ) -> None:
        """`on_port` is called when the port of a PASV or EPSV is open, and the next command may come."""
        self._connection, self._files, self._data, self._reply = connection, files, data, reply
        self._on_open = on_port
        self.is_opening = False
        """True until the port of a PASV or EPSV is known, with which its reply begins."""
        self.facts: tuple[str, ...] = listing.FACTS
        """The facts of MLSD and MLST that the client has chosen."""
        self._old_name: str | None = None
        self._restart = 0
        """The byte at which the next transfer begins (REST)."""
        self._is_only_epsv = False
        self._table: dict[str, Command] = {
            "PWD": lambda _: reply('257 "/" is the current folder.'),
            "CWD": self._change_folder,
            "CDUP": lambda _: reply(Reply.OKAY),
            "TYPE": self._type,
            "MODE": partial(self._only, "S"),
            "STRU": partial(self._only, "F"),
            "ALLO": self._allocate,
            "ACCT": lambda _: reply(Reply.NOT_NEEDED),
            "PASV": lambda _: self._passive(self._pasv_reply),
            "EPSV": self._epsv,
            "PORT": lambda argument: self._active(addresses.of_port, argument),
            "EPRT": lambda argument: self._active(addresses.of_eprt, argument),
            "LIST": self._lister(lambda names: listing.long_list(files, names)),
            "NLST": self._lister(listing.short_list),
            "MLSD": self._lister(lambda names: listing.fact_list(files, names, self.facts)),
            "MLST": self._facts,
            "STAT": self._status,
            "REST": self._restart_at,
            "RETR": lambda name: self._start(lambda restart: Send(rest_of(files.read(files.name_of(name)), restart))),
            "STOR": lambda path: self._start(partial(self._stored, path)),
            "APPE": lambda path: self._start(lambda _: self._appended(path)),
            "ABOR": lambda _: self._abort(),
            "SIZE": partial(self._about, lambda name: str(len(files.read(name)))),
            "MDTM": partial(self._about, self._date),
            "DELE": lambda name: self._change(lambda: files.delete(files.name_of(name))),
            "RNFR": self._rename_from,
            "RNTO": self._rename_to,
            "MKD": lambda _: reply(Reply.NO_FOLDERS),
            "RMD": lambda _: reply(Reply.NO_FOLDERS),
        }

    def __contains__(self, verb: str) -> bool:
        return verb in self._table

    @property
    def verbs(self) -> list[str]:
        return list(self._table)

    def run(self, verb: str, argument: str) -> None:
        """Carry out a command of the table."""
        if verb in NEED_ARGUMENT and not argument.strip():
            self._reply(Reply.WRONG_ARGUMENT)
        else:
            self._table[verb](argument)

    def forget_name(self) -> None:
        """Forget the name of RNFR, because another command than RNTO follows it."""
        self._old_name = None

    def reset(self) -> None:
        """Forget everything that a user has set, and end the transfer."""
        self._old_name, self._restart, self._is_only_epsv = None, 0, False
        self._data.abort()
        self._connection.stop_listening()

    def _change_folder(self, path: str) -> None:
        self._reply(Reply.DONE if listing.is_folder(path) else Reply.NO_FOLDERS)

    def _allocate(self, argument: str) -> None:
        self._reply(Reply.NOT_NEEDED if SPACE.fullmatch(argument) else Reply.WRONG_ARGUMENT)

    def _type(self, argument: str) -> None:
        is_known = argument.upper() in ("A", "A N", "I", "L 8")
        self._reply(Reply.OKAY if is_known else Reply.WRONG_TYPE)

    def _only(self, value: str, argument: str) -> None:
        self._reply(Reply.OKAY if argument.upper() == value else Reply.WRONG_TYPE)

    # ---- files

    def _about(self, find: Callable[[str], str], path: str) -> None:
        try:
            self._reply(f"213 {find(self._files.name_of(path))}")
        except ValueError as cause:
            self._reply(refused(550, cause))

    def _date(self, name: str) -> str:
        self._files.read(name)
        return listing.DATE

    def choose_facts(self, argument: str) -> None:
        """Take the facts that a client wants (RFC 3659, 7.9); what is no fact of ours is left out."""
        wanted = argument.lower().split(";")
        self.facts = tuple(fact for fact in listing.FACTS if fact in wanted)
        self._reply(" ".join(("200 MLST OPTS", *filter(None, ["".join(f"{fact};" for fact in self.facts)]))))

    def _facts(self, path: str) -> None:
        try:
            if listing.is_folder(path):
                facts = listing.folder_facts(self.facts)
            else:
                facts = listing.facts(self._files, self._files.name_of(path), self.facts)
            self._reply(lines_of(250, "Facts:", [facts], "End"))
        except ValueError as cause:
            self._reply(refused(550, cause))

    def _status(self, argument: str) -> None:
        if not argument:
            state = "A transfer is under way." if self._data.is_busy else "No transfer is under way."
            self._reply(lines_of(211, "Status:", [f"Connected to {self._connection.peer}.", state], "End"))
            return
        try:
            lines = listing.long_list(self._files, listing.chosen(self._files, argument)).decode().splitlines()
            self._reply(lines_of(213, "Status:", lines, "End"))
        except ValueError as cause:
            self._reply(refused(550, cause))

    def _change(self, action: Callable[[], None]) -> None:
        try:
            action()
        except ValueError as cause:
            self._reply(refused(550, cause))
        else:
            self._reply(Reply.DONE)

    def _rename_from(self, path: str) -> None:
        try:
            name = self._files.name_of(path)
            self._files.read(name)
        except ValueError as cause:
            self._reply(refused(550, cause))
        else:
            self._old_name = name
            self._reply(Reply.NEED_NEW_NAME)

    def _rename_to(self, path: str) -> None:
        old_name, self._old_name = self._old_name, None
        if old_name is None:
            self._reply(Reply.WRONG_ORDER)
            return
        try:
            self._files.rename(old_name, self._new_name(path))
        except ValueError as cause:
            self._reply(refused(code_of(cause), cause))
        else:
            self._reply(Reply.DONE)

    def _new_name(self, path: str) -> str:
        try:
            return self._files.name_of(path)
        except ValueError as cause:
            raise ForbiddenNameError(str(cause)) from cause

    # ---- data connections

    def _epsv(self, argument: str) -> None:
        self._is_only_epsv |= argument.upper() == "ALL"
        if argument.upper() == "ALL":
            self._reply(Reply.OKAY)
        elif argument in ("", family := addresses.FAMILIES[addresses.plain(self._connection.local).version]):
            self._passive(lambda port: f"229 Entering Extended Passive Mode (|||{port}|)", is_epsv=True)
        else:
            self._reply(f"522 Network protocol not supported, use ({family})")

    def _passive(self, reply: Callable[[int], str], *, is_epsv: bool = False) -> None:
        if self._is_only_epsv and not is_epsv:
            self._reply(Reply.WRONG_ORDER)
            return
        self._data.open()
        self.is_opening = True
        self._connection.listen(partial(self._on_port, reply), self._accept)

    def _on_port(self, reply: Callable[[int], str], port: int) -> None:
        self.is_opening = False
        self._reply(reply(port) if port else Reply.NO_DATA_CONNECTION)
        self._on_open()

    def _accept(self, connection: Connection) -> Session:
        self._connection.stop_listening()
        return self._data.accept(connection)

    def _pasv_reply(self, port: int) -> str:
        address = addresses.plain(self._connection.local)
        if not isinstance(address, IPv4Address):
            return Reply.NO_DATA_CONNECTION  # RFC 2428: EPSV is for these
        return f"227 Entering Passive Mode ({addresses.as_pasv(address, port)})."

    def _active(self, parse: Callable[[str], tuple[Address, int]], argument: str) -> None:
        """Take the address to which the data connection of the next transfer is opened: one of the client only."""
        try:
            address, port = parse(argument)
        except FamilyError:
            self._reply(Reply.WRONG_FAMILY)
            return
        except ValueError as cause:
            self._reply(refused(501, cause))
            return
        if self._is_only_epsv:
            self._reply(Reply.WRONG_ORDER)
        elif addresses.plain(str(address)) != addresses.plain(self._connection.peer) or port < addresses.FIRST_PORT:
            self._reply(Reply.WRONG_ADDRESS)  # RFC 2577, 3: else the server would attack others for the client
        else:
            self._connection.stop_listening()
            self._data.open(lambda: self._connection.connect(port, self._data.refused, self._accept))
            self._reply(Reply.OKAY)

    # ---- transfers

    def _lister(self, form: Callable[[list[str]], bytes]) -> Command:
        return lambda argument: self._start(lambda _: Send(form(listing.chosen(self._files, argument))))

    def _restart_at(self, argument: str) -> None:
        if argument.isascii() and argument.isdigit() and int(argument) <= HIGHEST_RESTART:
            self._restart = int(argument)
            self._reply(f"350 The next transfer begins at byte {self._restart}.")
        else:
            self._reply(Reply.WRONG_ARGUMENT)

    def _stored(self, path: str, restart: int) -> Store:
        name = self._new_name(path)
        return Store(self._files, name, beginning_of(content_of(self._files, name), restart))

    def _appended(self, path: str) -> Store:
        name = self._new_name(path)
        return Store(self._files, name, content_of(self._files, name))

    def _start(self, job: Callable[[int], Job]) -> None:
        restart, self._restart = self._restart, 0  # for this command only, also if it is refused (RFC 3659, 5.3)
        if not self._data.is_open:
            self._reply(Reply.NO_DATA_CONNECTION)
            return
        try:
            self._data.start(job(restart))
        except ValueError as cause:
            self._reply(refused(code_of(cause), cause))

    def abort_transfer(self) -> None:
        """End the transfer that is under way, for an ABOR that comes after it."""
        if self._data.abort():
            self._connection.stop_listening()
            self._reply(Reply.TRANSFER_ABORTED)

    def _abort(self) -> None:
        self._data.abort()
        self._connection.stop_listening()
        self._reply(Reply.ABORTED)


def code_of(cause: ValueError) -> int:
    """Return the code of the reply that refuses a transfer (RFC 959, 4.2; RFC 3659, 5.3)."""
    codes = {RestartError: 554, ForbiddenNameError: 553}
    return codes.get(type(cause), 550)
