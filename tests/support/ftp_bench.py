"""A client of FTP on a virtual clock, and a folder in memory."""

from tcp_client import ServedConnection

from fieldrig.clock import S, VirtualClock
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.ftp.server import serving


class Folder:
    """Files in memory, with room for 1000 bytes."""

    def __init__(self) -> None:
        self.files = {"A.HTM": b"page a", "B.HTM": b"page b"}

    @property
    def names(self) -> list[str]:
        return sorted(self.files)

    @property
    def free(self) -> int:
        return 1000 - sum(map(len, self.files.values()))

    def name_of(self, path: str) -> str:
        name = path.removeprefix("/").upper()
        if not name or "/" in name or ".." in name:
            raise ValueError(f"expected a file name, got {path!r}")
        return name

    def read(self, name: str) -> bytes:
        if name not in self.files:
            raise ValueError(f"expected the name of a file, got {name}\nmore")
        return self.files[name]

    def write(self, name: str, data: bytes) -> None:
        if len(data) - len(self.files.get(name, b"")) > self.free:
            raise ValueError("the disk is full")
        self.files[name] = data

    def delete(self, name: str) -> None:
        self.read(name)
        del self.files[name]

    def rename(self, name: str, new: str) -> None:
        self.files[new] = self.read(name)
        del self.files[name]


class Client:
    def __init__(self, *, is_logged_in: bool = True) -> None:
        self.clock = VirtualClock()
        self.folder = Folder()
        self.refused: list[str] = []
        self.serve = serving(self.clock, self.folder, FtpLogin("service", "pacdrive", self.refused.append))
        self.control = self.connect()
        if is_logged_in:
            assert self.do("USER service") == "331"
            assert self.do("PASS pacdrive") == "230"

    def connect(self) -> ServedConnection:
        control = ServedConnection(self.serve)
        assert control.take() == b"220 Service ready.\r\n"
        return control

    def do(self, command: str) -> str:
        """The codes of the replies to a command."""
        return " ".join(line[:3] for line in self.ask(command).split("\r\n") if line[:3].isdigit() and line[3:4] == " ")

    def ask(self, command: str) -> str:
        return self.control.send(f"{command}\r\n".encode()).decode()

    def data(self) -> ServedConnection:
        assert self.control.serve_extra is not None
        return ServedConnection(self.control.serve_extra)

    def run(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))

    def codes(self) -> str:
        return " ".join(line[:3] for line in self.control.take().decode().split("\r\n") if line)
