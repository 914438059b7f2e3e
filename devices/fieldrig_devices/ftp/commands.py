"""The commands of FTP after the login: files, their transfer, and the parameters of a transfer.

Source: RFC 959, 4.1; RFC 2428; RFC 3659, 4.
"""

from collections.abc import Callable
from functools import partial
from ipaddress import ip_address

from fieldrig_devices.connections.connection import Connection, Session
from fieldrig_devices.ftp.files import Files
from fieldrig_devices.ftp.jobs import Send, Store, long_list, short_list
from fieldrig_devices.ftp.replies import Reply, refused
from fieldrig_devices.ftp.transfer import DataPort, Job

Command = Callable[[str], None]


class FileCommands:
    """The commands of one control connection, by their verbs."""

    def __init__(self, connection: Connection, files: Files, data: DataPort, reply: Callable[[str], None]) -> None:
        self._connection, self._files, self._data, self._reply = connection, files, data, reply
        self._old_name: str | None = None
        self._table: dict[str, Command] = {
            "PWD": lambda _: reply('257 "/" is the current folder.'),
            "CWD": self._change_folder,
            "CDUP": lambda _: reply(Reply.OKAY),
            "TYPE": self._type,
            "MODE": partial(self._only, "S"),
            "STRU": partial(self._only, "F"),
            "ALLO": lambda _: reply(Reply.NOT_NEEDED),
            "PASV": lambda _: self._passive(self._pasv_reply),
            "EPSV": self._epsv,
            "LIST": lambda _: self._start(lambda: Send(long_list(files, files.names))),
            "NLST": lambda _: self._start(lambda: Send(short_list(files.names))),
            "RETR": lambda name: self._start(lambda: Send(files.read(files.name_of(name)))),
            "STOR": lambda name: self._start(lambda: Store(files, files.name_of(name))),
            "ABOR": lambda _: self._abort(),
            "SIZE": self._size,
            "DELE": lambda name: self._change(lambda: files.delete(files.name_of(name))),
            "RNFR": self._rename_from,
            "RNTO": self._rename_to,
            "MKD": lambda _: reply(Reply.NO_FOLDERS),
            "RMD": lambda _: reply(Reply.NO_FOLDERS),
        }

    def __contains__(self, verb: str) -> bool:
        return verb in self._table

    def run(self, verb: str, argument: str) -> None:
        """Carry out a command of the table."""
        self._table[verb](argument)

    def forget_name(self) -> None:
        """Forget the name of RNFR, because another command than RNTO follows it."""
        self._old_name = None

    def _change_folder(self, path: str) -> None:
        self._reply(Reply.DONE if path in ("/", ".", "..", "\\", "") else Reply.NO_FOLDERS)

    def _type(self, argument: str) -> None:
        is_known = argument.upper() in ("A", "A N", "I", "L 8")
        self._reply(Reply.OKAY if is_known else Reply.WRONG_TYPE)

    def _only(self, value: str, argument: str) -> None:
        self._reply(Reply.OKAY if argument.upper() == value else Reply.WRONG_TYPE)

    # ---- files

    def _size(self, path: str) -> None:
        try:
            self._reply(f"213 {len(self._files.read(self._files.name_of(path)))}")
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
        else:
            self._change(lambda: self._files.rename(old_name, self._files.name_of(path)))

    # ---- data connections

    def _epsv(self, argument: str) -> None:
        if argument.upper() in ("", "1", "2", "ALL"):
            self._passive(lambda port: f"229 Entering Extended Passive Mode (|||{port}|)")
        else:
            self._reply("522 Network protocol not supported, use (1,2)")

    def _passive(self, reply: Callable[[int], str]) -> None:
        if self._data.is_busy:
            self._reply(Reply.WRONG_ORDER)
            return
        self._data.open()
        self._connection.listen(partial(self._on_port, reply), self._accept)

    def _on_port(self, reply: Callable[[int], str], port: int) -> None:
        self._reply(reply(port) if port else Reply.NO_DATA_CONNECTION)

    def _accept(self, connection: Connection) -> Session:
        self._connection.stop_listening()
        return self._data.accept(connection)

    def _pasv_reply(self, port: int) -> str:
        address = ip_address(self._connection.local)
        if address.version == 6:
            if address.ipv4_mapped is None:
                return Reply.NO_DATA_CONNECTION  # RFC 2428: EPSV is for these
            address = address.ipv4_mapped
        numbers = ",".join(map(str, (*address.packed, *divmod(port, 256))))
        return f"227 Entering Passive Mode ({numbers})."

    def _start(self, job: Callable[[], Job]) -> None:
        if self._data.is_busy or not self._data.is_open:
            self._reply(Reply.WRONG_ORDER if self._data.is_busy else Reply.NO_DATA_CONNECTION)
            return
        try:
            self._data.start(job())
        except ValueError as cause:
            self._reply(refused(550, cause))

    def _abort(self) -> None:
        if self._data.abort():
            self._reply(Reply.TRANSFER_ABORTED)
        self._connection.stop_listening()
        self._reply(Reply.ABORTED)
