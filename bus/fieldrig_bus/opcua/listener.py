"""The TCP connections of an OPC UA server, with the limits of every port of fieldrig.

asyncua answers one message at a time here, and the next one is read when that is done, or when it has waited for a
device for so long that others would suffer.  The library's own listener takes messages as fast as they come: 500 of a
connection wait there, each with all bytes that were read after it.

Source of the header: OPC 10000-6, 7.1.2.2.
"""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Final

from asyncua import Server, ua
from asyncua.common.utils import Buffer, ServiceError
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.ua_binary import header_from_binary, struct_from_binary

from fieldrig.outside.limits import Limits
from fieldrig_bus.net import Connection, TcpServer
from fieldrig_bus.opcua.requests import check_some, wrong_member
from fieldrig_bus.opcua.session import Backend

log = logging.getLogger(__name__)

MOST_WAITING: Final = 16
"""Messages of a connection that may wait for an answer; nothing is read from it while it has more."""
LONGEST_CHUNK: Final = 65_535
LONGEST_MESSAGE: Final = 4 << 20
"""Longest message of a client, in bytes; the library's limit is 100 MB, which every connection may fill."""
LEAST: Final = 8
"""Bytes of the header that have the size."""
BROWSE_NEXT: Final = ua.NodeId(ua.ObjectIds.BrowseNextRequest_Encoding_DefaultBinary)
REGISTER_NODES: Final = ua.NodeId(ua.ObjectIds.RegisterNodesRequest_Encoding_DefaultBinary)
UNREGISTER_NODES: Final = ua.NodeId(ua.ObjectIds.UnregisterNodesRequest_Encoding_DefaultBinary)
MODIFY_SUBSCRIPTION: Final = ua.NodeId(ua.ObjectIds.ModifySubscriptionRequest_Encoding_DefaultBinary)
LIMITS: Final = Limits(connections=100)


class LimitedServer(Server):  # type: ignore[misc]
    """The library's server without its listener."""

    async def start(self) -> None:
        """Prepare the endpoints, and start what needs no connection."""
        self.limits.max_message_size = LONGEST_MESSAGE
        self.limits.max_chunk_count = LONGEST_MESSAGE // LONGEST_CHUNK
        await self._setup_server_nodes()
        await self.iserver.start()

    def listener(self, address: str) -> TcpServer:
        """Return a listener for the clients of this server."""
        server = TcpServer(address, lambda server: Client(server, self.iserver, self._processor), LIMITS, "OPC UA")
        self.iserver.reached = server.door.reached
        return server

    def _processor(self, transport: asyncio.Transport) -> UaProcessor:
        processor = Processor(self.iserver, transport, self.limits)
        processor.set_policies(self._policies)
        return processor


class Processor(UaProcessor):  # type: ignore[misc]
    """The library's services, and those that it lacks or carries out without their parameters."""

    async def _process_message(self, typeid: ua.NodeId, requesthdr: Any, seqhdr: Any, body: Any) -> bool:
        response = None
        if self.session is not None and self.session.is_activated():
            response = await self._answer(typeid, body)
        if response is None:
            try:
                goes_on: bool = await super()._process_message(typeid, requesthdr, seqhdr, body)
            except ValueError as cause:
                if status := wrong_member(cause):
                    raise ServiceError(status) from cause
                raise
            return goes_on
        self.session_last_activity = time.monotonic()
        self.session.touch()
        self.send_response(requesthdr.RequestHandle, seqhdr, response)
        return True

    async def _answer(self, typeid: ua.NodeId, body: Any) -> Any:
        """Return the response to a request of one of these services, and None for any other."""
        if typeid == BROWSE_NEXT:
            response = ua.BrowseNextResponse()
            asked = struct_from_binary(ua.BrowseNextParameters, body)
            response.Parameters.Results = await self.session.browse_next(asked)
            return response
        if typeid == MODIFY_SUBSCRIPTION:
            response = ua.ModifySubscriptionResponse()
            changed = struct_from_binary(ua.ModifySubscriptionParameters, body)
            response.Parameters = await self.session.change_subscription(changed)
            return response
        if typeid == REGISTER_NODES:
            response = ua.RegisterNodesResponse()
            named = struct_from_binary(ua.RegisterNodesParameters, body)
            check_some(named.NodesToRegister)
            response.Parameters.RegisteredNodeIds = named.NodesToRegister  # no other name of them is faster
            return response
        if typeid == UNREGISTER_NODES:
            check_some(struct_from_binary(ua.UnregisterNodesParameters, body).NodesToUnregister)
            return ua.UnregisterNodesResponse()
        return None


class WrongHeaderError(ValueError):
    """The bytes are no messages of OPC UA."""


class Messages:
    """Splits a stream into messages."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield every message that `data` completes.  WrongHeaderError for a header that none has."""
        self._rest += data
        while len(self._rest) >= LEAST:
            size = int.from_bytes(self._rest[4:LEAST], "little")
            if self._rest[:3] not in KINDS or not LEAST < size <= LONGEST_CHUNK:
                raise WrongHeaderError(f"not a message of OPC UA: {self._rest[:LEAST].hex(' ')}")
            if len(self._rest) < size:
                return
            message, self._rest = self._rest[:size], self._rest[size:]
            yield message


LONG_S: Final = 0.1
"""How long a message may keep those behind it from being answered; a client's watchdog is one of them.

A request that a device has not answered by then is answered when it can be, as OPC 10000-4, 5.3 allows any order.
"""
KINDS: Final = (b"HEL", b"ACK", b"ERR", b"RHE", b"OPN", b"MSG", b"CLO")


class Client(Connection):
    """One connection."""

    def __init__(
        self, server: TcpServer, backend: Backend, processor: Callable[[asyncio.Transport], UaProcessor]
    ) -> None:
        super().__init__(server)
        self._backend, self._make_processor = backend, processor
        self._messages = Messages()
        self._waiting: deque[bytes] = deque()
        self._may_go_on, self._turn = asyncio.Event(), asyncio.Event()
        self._is_stopped = False
        self._workers: set[asyncio.Task[None]] = set()
        """The tasks that answer messages: the present one, and those that still wait for a device."""
        self._present: asyncio.Task[None] | None = None
        """The task that takes the next message."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._name = transport.get_extra_info("peername")
        self._processor: Any = self._make_processor(self.transport)
        self._work_on()

    def data_received(self, data: bytes) -> None:
        try:
            self._waiting.extend(self._messages.feed(data))
        except WrongHeaderError as wrong:
            log.debug("%s: %s", self._name, wrong)
            self.transport.abort()
        self._look()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        for worker in self._workers:
            worker.cancel()
        self._backend.forget(self._name)
        self._backend.close_later(self._processor.close())
        del self._processor, self._make_processor  # no circle that the collector has to find

    def pause_writing(self) -> None:
        super().pause_writing()
        self._look()

    def resume_writing(self) -> None:
        super().resume_writing()
        self._look()

    def take_turn(self) -> None:
        super().take_turn()
        self._turn.set()

    def _look(self) -> None:
        """Stop a client that sends more than is answered, or that does not read."""
        is_stopped = len(self._waiting) >= MOST_WAITING or self.is_full
        if is_stopped and not self._is_stopped:
            self.server.door.reached.note(
                "clients that had to wait", f"{self._name} sends messages faster than they are answered"
            )
        self._is_stopped = is_stopped
        self.read_on(not is_stopped)
        if self._waiting and not self.is_full:
            self._may_go_on.set()
        else:
            self._may_go_on.clear()

    def _work_on(self) -> None:
        """Take the next messages in a task of their own."""
        worker = self._present = asyncio.get_running_loop().create_task(self._work())
        self._workers.add(worker)
        worker.add_done_callback(self._workers.discard)

    async def _work(self) -> None:
        """Answer one message after another, until one of them takes so long that another task goes on."""
        loop, this = asyncio.get_running_loop(), asyncio.current_task()
        while self._present is this:
            await self._may_go_on.wait()
            if self.pace is not None and not self.pace.is_free(self):
                self._turn.clear()
                await self._turn.wait()
            message = self._waiting.popleft()
            self._look()
            others = loop.call_later(LONG_S, self._work_on)
            try:
                goes_on = await self._is_answered(message)
            finally:
                others.cancel()
            if not goes_on:
                self.transport.close()
                return
            if self._processor.session is not None and self._processor.session.is_activated():
                self.heard()
            await asyncio.sleep(0)  # others have their turn, also when the answer needed no waiting

    async def _is_answered(self, message: bytes) -> bool:
        """Return whether the connection goes on."""
        buffer = Buffer(message)
        asked_ns = time.monotonic_ns()
        try:
            goes_on: bool = await self._processor.process(header_from_binary(buffer), buffer)
        except Exception as wrong:  # noqa: BLE001  the library raises many kinds for wrong bytes, also AttributeError
            log.debug("%s: %r", self._name, wrong)
            return False
        finally:
            if self.pace is not None:
                self.pace.answered(asked_ns)
        return goes_on
