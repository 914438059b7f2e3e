"""`opcua.server`: any OPC UA client can browse, read, write, subscribe to and call the nodes of the devices.

Source: OPC 10000-3, -4, -6 and -8; the protocol itself is asyncua's.  On loopback the server is open.  Beyond it, and
with `security: sign_and_encrypt` everywhere, it accepts only Basic256Sha256 with signed and encrypted messages, and the
users of the rig file with the rig's token as password.  Clients may use any certificate: users prove themselves by the
token.  Left out: history, alarms and conditions, transfer of subscriptions.
"""

import asyncio
import logging
import re
import socket
from collections.abc import Collection, Hashable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

from asyncua import Server, ua
from pydantic import Field

from fieldrig.bus import Hub, ModelBus, Port, Time, words_of
from fieldrig.device import Tool, WayIn, python_line
from fieldrig.errors import BusError
from fieldrig.outside.addresses import is_loopback, split_address
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, make_token, token
from fieldrig.settings import Address, WrongKey
from fieldrig.text.nearest import closest
from fieldrig_bus.net import HubSettings, ServingPort, TcpServer
from fieldrig_bus.opcua import codec, own_nodes, traced
from fieldrig_bus.opcua.address_space import AddressSpace
from fieldrig_bus.opcua.certificate import make_certificate
from fieldrig_bus.opcua.devices import Devices
from fieldrig_bus.opcua.faults import MODELS, OpcUaEffects, OpcUaFault
from fieldrig_bus.opcua.library_log import quieten
from fieldrig_bus.opcua.listener import LimitedServer
from fieldrig_bus.opcua.message import ANSWERS, REQUESTS, Offer, OpcUaMessage
from fieldrig_bus.opcua.model import SERVER, OpcUaModel
from fieldrig_bus.opcua.session import Backend
from fieldrig_bus.opcua.users import Right, Users

log = logging.getLogger(__name__)

SECURE: Final = [ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt]
OPEN: Final = [ua.SecurityPolicyType.NoSecurity]


class OpcUaSettings(HubSettings):
    listen: Address = Field(default="127.0.0.1:4840", description="host:port for clients")
    security: Literal["auto", "sign_and_encrypt"] = Field(
        default="auto",
        description="sign_and_encrypt: Basic256Sha256 and users also on loopback; auto: beyond loopback only",
    )
    users: dict[str, Right] = Field(
        default={"fieldrig": "write"},
        min_length=1,
        description="user names with their rights, read or write; the password of all is the rig's token",
    )
    fastest_sampling_ms: Annotated[float, Field(ge=1, le=60_000)] = Field(
        default=10.0, description="shortest sampling interval of subscriptions"
    )

    faults: list[OpcUaFault] = Field(default_factory=list, description="faults from the start")
    order: list[str] = Field(
        default_factory=list,
        description="devices in the order of their namespaces, from index 2 on; others follow as they arrive",
    )

    def wrong_for(self, members: Sequence[str], masters: Collection[str]) -> Iterator[WrongKey]:
        for index, device in enumerate(self.order):
            if device not in members:
                yield WrongKey(("order", index), f"{device} has no link to this bus", closest(device, list(members)))

    @property
    def is_secure(self) -> bool:
        return self.security == "sign_and_encrypt" or not is_loopback(split_address(self.listen)[0])


class OpcUaServer(ModelBus[OpcUaMessage]):
    about: ClassVar[str] = "OPC UA: any client can browse, read, write and subscribe to the devices of this bus"
    times: ClassVar[frozenset[Time]] = frozenset({"real", "virtual"})
    family: ClassVar[str] = "opcua"
    notes_faults: ClassVar[bool] = True
    serves_outsiders: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (Offer, *REQUESTS, *ANSWERS)
    own_process: ClassVar[bool] = True

    fault_models = MODELS

    encode = staticmethod(traced.encode)
    decode = staticmethod(traced.decode)
    show = staticmethod(traced.show)
    check = staticmethod(codec.check_sent)

    def __init__(self, name: str, settings: OpcUaSettings) -> None:
        super().__init__(name, settings)

    def check_interest(self, interest: Any) -> None:
        """Raise ValueError or TypeError for any interest, because each end receives what is meant for it."""
        if any(True for _ in words_of(interest)):
            raise ValueError("expected no interest, because each end receives what is meant for it")

    def model(self) -> OpcUaModel:
        return OpcUaModel()

    def effects(self) -> OpcUaEffects:
        return OpcUaEffects(self.settings.faults)

    @staticmethod
    def standing_of(message: OpcUaMessage) -> Hashable:
        """An offer stands until the device makes another one."""
        return message.device if isinstance(message, Offer) else None

    def ports(self) -> Sequence[Port]:
        quieten()
        return (OpcUaPort(self.name, self.settings),)

    @property
    def url(self) -> str:
        host, port = split_address(self.settings.listen)
        return f"opc.tcp://{host}:{port}"

    def ways_in(self, run: Path) -> list[WayIn]:
        secured = ", Basic256Sha256" if self.settings.is_secure else ""
        return [WayIn(f"OPC UA{secured}", self.url)]

    def tools(self, run: Path) -> list[Tool]:
        if self.settings.is_secure:  # a client needs a certificate and a password of its own
            return []
        steps = (
            "from asyncua.sync import Client",
            f"c = Client({self.url!r})",
            "c.connect()",
            "print([node.read_browse_name().Name for node in c.nodes.objects.get_children()])",
            "c.disconnect()",
        )
        return [Tool("what it offers", python_line("; ".join(steps)))]


class OpcUaPort(ServingPort):
    def __init__(self, name: str, settings: OpcUaSettings) -> None:
        self._name, self._settings = name, settings
        self._server: LimitedServer | None = None
        self._listener: TcpServer | None = None
        self._changes: Any = None
        self._offers: dict[str, int] = {}
        self._taking = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def number(self) -> int:
        """The TCP port on which it listens."""
        return self._listener.port if self._listener is not None else split_address(self._settings.listen)[1]

    def servers(self) -> Iterable[TcpServer]:
        return () if self._listener is None else (self._listener,)

    async def open(self, hub: Hub) -> None:
        host, port = split_address(self._settings.listen)
        backend = Backend(self._users(), self._settings.fastest_sampling_ms)
        server = LimitedServer(iserver=backend)
        await server.init()
        run = hub.path("opcua")
        rig = re.sub(r"\W", "-", run.parent.name)
        self._application = f"urn:fieldrig:{rig}"
        await server.set_application_uri(f"{self._application}:{self._name}")
        server.set_server_name(f"fieldrig {rig}")
        await own_nodes.fill(server, self._settings.fastest_sampling_ms)
        server.set_endpoint(f"opc.tcp://{host}:{port}")
        await self._secure(server, run, host)
        self._server, self._backend = server, backend
        link = hub.join(SERVER)
        self._hub = hub
        backend.devices = Devices(link, self._on_offer, self._hang_up)
        backend.space = self._space = AddressSpace(server, backend.devices)
        for device in self._settings.order:
            await self._namespace(device)
        self._changes = await server.get_event_generator(ua.ObjectIds.GeneralModelChangeEventType)
        self._changes.event.data_types["Changes"] = ua.VariantType.ExtensionObject
        await server.start()
        listener = server.listener(self._settings.listen)
        try:
            await listener.open(hub.pace)
        except BusError:
            await server.iserver.stop()
            raise
        self._listener = listener

    async def close(self) -> None:
        if self._server is not None:
            for task in self._tasks:
                task.cancel()
            await self._backend.sampler.close()
            if self._listener is not None:
                await self._listener.close()
                await self._backend.close_all()
                await self._server.iserver.stop()
                self._listener = None
            self._hub.leave(SERVER)
            self._server = None

    # ---- what is behind it

    def _on_offer(self, offer: Offer) -> None:
        task = asyncio.get_running_loop().create_task(self._take(offer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _hang_up(self) -> None:
        """Close the connections of all clients; they may connect again."""
        for connection in list(self._listener.connections if self._listener is not None else ()):
            connection.transport.abort()

    async def _take(self, offer: Offer) -> None:
        """Show a new device, or what has changed in one."""
        async with self._taking:
            if self._offers.get(offer.device) == offer.generation:
                return
            self._offers[offer.device] = offer.generation
            if not self._space.is_known(offer.device):
                index = await self._namespace(offer.device)
                self._space.add_device(offer.device, offer.about, index)
                return
            changes = await self._space.update(offer.device)
            self._changes.event.Changes = changes
            self._changes.event.Message = ua.LocalizedText(f"the nodes of {offer.device} have changed")
            await self._changes.trigger()

    async def _namespace(self, device: str) -> int:
        assert self._server is not None
        index: int = await self._server.register_namespace(f"{self._application}:{device}")
        return index

    # ---- security

    def _users(self) -> Users:
        settings = self._settings
        if not settings.is_secure:
            return Users(settings.users, token(), is_open=True)
        make_token()
        password = token()
        if password is None:
            raise BusError(
                f"{self._name}: {settings.listen} needs users with a password, and the rig has no token",
                f"set {TOKEN_VARIABLE}, or name a file for the token in {FILE_VARIABLE}",
            )
        return Users(settings.users, password, is_open=False)

    async def _secure(self, server: Server, run: Path, host: str) -> None:
        if not self._settings.is_secure:
            server.set_security_policy(OPEN)
            server.set_identity_tokens([ua.AnonymousIdentityToken, ua.UserNameIdentityToken])
            return
        name = socket.gethostname() if host in ("0.0.0.0", "::") else host
        certificate, key = await make_certificate(run / self._name, server.get_application_uri(), name)
        await server.load_certificate(certificate)
        await server.load_private_key(key)
        server.set_security_policy(SECURE)
        server.set_identity_tokens([ua.UserNameIdentityToken])
