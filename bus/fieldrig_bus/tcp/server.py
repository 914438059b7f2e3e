"""`tcp.server`: any client can connect by TCP to the services of the devices, such as `http` and `ftp`.

Each service has `max_connections`, of which one client may have three quarters.  One more is closed at once, or takes
the place of one that has not sent a complete message yet.  A client that does not read stops its device from sending
more, and a device that is slow stops its clients.  An extra port, which passive FTP needs, accepts the address of its
client only.
Left out: TLS, urgent data.
"""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from fieldrig.bus import ModelBus, Port, Time, words_of
from fieldrig.device import Tool, WayIn
from fieldrig.settings import Address
from fieldrig_bus.net import HubSettings
from fieldrig_bus.tcp import codec
from fieldrig_bus.tcp.faults import MODELS, TcpEffects, TcpServiceFault
from fieldrig_bus.tcp.listeners import TcpPort
from fieldrig_bus.tcp.message import KINDS, SERVICE, TcpMessage, check_sent
from fieldrig_bus.tcp.model import TcpModel

log = logging.getLogger(__name__)

Service = Annotated[str, Field(pattern=f"^{SERVICE.pattern}$", examples=["http"])]
TOOLS = {"http": "curl http://{}/", "ftp": "curl ftp://{}/ --user NAME"}


class TcpSettings(HubSettings):
    listen: dict[Service, Address] = Field(
        default={"http": "127.0.0.1:8080"},
        min_length=1,
        description="host:port for clients, by the name of the service",
    )
    max_connections: int = Field(
        default=64,
        ge=1,
        le=10_000,
        description="connections of each service, three quarters of them of one client; one more is closed at once",
    )
    extra_ports: tuple[int, int] | None = Field(
        default=None, description="first and last extra port, for the data of passive FTP; null: any free port"
    )

    faults: list[TcpServiceFault] = Field(default_factory=list, description="faults from the start")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.extra_ports is not None:
            first, last = self.extra_ports
            if not 1 <= first <= last <= 0xFFFF:
                raise ValueError(f"extra_ports: expected two ports from 1 to 65535 in order, got {first} and {last}")
        return self

    def offers(self) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
        for service in self.listen:
            yield ("listen", service), "service", service


class TcpServerBus(ModelBus[TcpMessage]):
    about: ClassVar[str] = (
        "TCP: any client can connect to the services of the devices of this bus, such as HTTP and FTP"
    )
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    family: ClassVar[str] = "tcp"
    notes_faults: ClassVar[bool] = True
    serves_outsiders: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = KINDS
    fault_models = MODELS

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(check_sent)

    def __init__(self, name: str, settings: TcpSettings) -> None:
        super().__init__(name, settings)

    def check_interest(self, interest: Any) -> None:
        """Raise ValueError or TypeError for anything but names of services."""
        for word in words_of(interest):
            if type(word) is not str or SERVICE.fullmatch(word) is None:
                raise ValueError(f"expected the name of a service such as http, found {word!r}")

    def model(self) -> TcpModel:
        return TcpModel()

    def effects(self) -> TcpEffects:
        return TcpEffects(self.settings.faults)

    def ports(self) -> Sequence[Port]:
        return (TcpPort(self.settings.listen, self.settings.max_connections, self.settings.extra_ports),)

    def ways_in(self, run: Path) -> list[WayIn]:
        return [
            WayIn(service.upper() if service in TOOLS else f"{service} by TCP", address)
            for service, address in self.settings.listen.items()
        ]

    def tools(self, run: Path) -> list[Tool]:
        return [
            Tool(service, TOOLS.get(service, "nc {}").format(address))
            for service, address in self.settings.listen.items()
        ]
