"""A controller with simulated axes and its TCP services, with this bench as the port that accepts clients."""

from typing import Any, Self

from max4_rig import Max4Rig

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.tcp.message import Close, Connected, Data, TcpMessage
from fieldrig_bus.tcp.model import PORT


class PageBench(Max4Rig):
    """Other keywords are settings of the controller, which has booted."""

    def __init__(self, *axes: str, **settings: Any) -> None:
        drives = {name: {"ring_address": place, "simulated": True} for place, name in enumerate(axes, 1)}
        config = from_dict(
            {
                "time": "virtual",
                "seed": 7,
                "buses": {"lan": {"kind": "tcp.server"}},
                "devices": {"max4": {"kind": "max4", "links": {"tcp": "lan"}, "drives": drives, **settings}},
            }
        )
        self.rig = Rig(config)
        self.port = self.rig.attach(PORT).link("lan")
        self.heard: list[TcpMessage] = []
        self.port.on_receive(self.heard.append)
        self._connections = 0
        self.run(2000)

    def connect(self, service: str = "http", origin: int = 0) -> int:
        """Connect a client, and return the number of its connection."""
        self._connections += 1
        self.port.send(Connected(self._connections, service, "192.168.10.7", "192.168.10.1", origin))
        return self._connections

    def send(self, connection: int, data: bytes) -> bytes:
        """Send bytes, and return the answer; the network takes everything."""
        self.heard.clear()
        self.port.send(Data(connection, data))
        self.rig.run_until(self.rig.now_ns + 10 * MS)
        return b"".join(message.data for message in self.heard if isinstance(message, Data))

    def is_closed(self, connection: int) -> bool:
        return Close(connection) in self.heard

    def page(self, path: str) -> tuple[str, str, str]:
        """Return the status, the type and the content of a page."""
        connection = self.connect()
        answer = self.send(connection, f"GET {path} HTTP/1.1\r\nHost: plc\r\nConnection: close\r\n\r\n".encode())
        if not answer:
            assert self.is_closed(connection)
            return "closed", "", ""
        head, _, content = answer.decode().partition("\r\n\r\n")
        (kind,) = (line.partition(": ")[2] for line in head.split("\r\n") if line.startswith("Content-Type"))
        return head.split()[1], kind, content

    def fault(self, where: str, **fault: Any) -> int:
        return self.rig.add_fault(where, fault)

    def heal(self, where: str, number: int) -> Self:
        self.rig.clear_fault(where, number)
        return self
