"""The devices behind a server: requests with their answers, and what each device offers."""

import asyncio
import logging
from collections.abc import Callable, Sequence
from typing import Final, TypeVar

from fieldrig.link import Link
from fieldrig_bus.opcua.codec import check_sent
from fieldrig_bus.opcua.message import (
    ANSWERS,
    MOST_PATHS,
    Answer,
    AnyValue,
    Browse,
    Call,
    Find,
    Hangup,
    Node,
    Nodes,
    Offer,
    OpcUaMessage,
    Outcome,
    Outcomes,
    Read,
    Request,
    Status,
    Write,
)

log = logging.getLogger(__name__)

A = TypeVar("A", Nodes, Outcomes)

PATIENCE_S: Final = 2.0
"""How long the server waits for a device; a device that is busy with its ring still answers between two cycles."""
NO_ANSWER: Final = Outcome(Status.NO_ANSWER)


class Devices:
    def __init__(
        self, link: Link[OpcUaMessage], on_offer: Callable[[Offer], None], on_hangup: Callable[[], None] = lambda: None
    ) -> None:
        self._link, self._on_offer, self._on_hangup = link, on_offer, on_hangup
        self._exchange = 0
        self._waiting: dict[int, asyncio.Future[Answer]] = {}
        link.on_receive(self._on_message)

    async def children(self, device: str, path: str) -> list[Node] | None:
        """Return all children of a node; None if the device does not answer."""
        nodes: list[Node] = []
        while True:
            answer = await self._ask(Browse(device, self._next(), path, len(nodes)), Nodes)
            if answer is None:
                return None
            nodes += answer.nodes
            if answer.is_complete or not answer.nodes:
                return nodes

    async def find(self, device: str, path: str) -> Node | None:
        answer = await self._ask(Find(device, self._next(), path), Nodes)
        return answer.nodes[0] if answer is not None and answer.nodes else None

    async def read(self, device: str, paths: Sequence[str]) -> list[Outcome]:
        """Return an outcome for each path."""
        outcomes: list[Outcome] = []
        while len(outcomes) < len(paths):
            some = tuple(paths[len(outcomes) : len(outcomes) + MOST_PATHS])
            answer = await self._ask(Read(device, self._next(), some), Outcomes)
            first = answer.outcomes[: len(some)] if answer is not None else ()
            outcomes += first or [NO_ANSWER] * len(some)
        return outcomes

    async def write(self, device: str, path: str, value: AnyValue) -> Outcome:
        return await self._outcome(Write(device, self._next(), path, value))

    async def call(self, device: str, path: str, arguments: Sequence[AnyValue] = ()) -> Outcome:
        return await self._outcome(Call(device, self._next(), path, tuple(arguments)))

    async def _outcome(self, request: Request) -> Outcome:
        try:
            check_sent(request)
        except ValueError:  # a value that no variable can have
            return Outcome(Status.OUT_OF_RANGE)
        answer = await self._ask(request, Outcomes)
        return answer.outcomes[0] if answer is not None and answer.outcomes else NO_ANSWER

    async def _ask(self, request: Request, answer_class: type[A]) -> A | None:
        """Return the answer; None if there is none in time."""
        loop = asyncio.get_running_loop()
        answer = self._waiting[request.exchange] = loop.create_future()
        self._link.send(request)
        try:
            async with asyncio.timeout(PATIENCE_S):
                reply = await answer
        except TimeoutError:
            log.warning("%s has not answered within %s s", request.device, PATIENCE_S)
            return None
        finally:
            self._waiting.pop(request.exchange, None)
        return reply if isinstance(reply, answer_class) else None

    def _next(self) -> int:
        self._exchange += 1
        return self._exchange

    def _on_message(self, message: OpcUaMessage | Hangup) -> None:
        if isinstance(message, Hangup):
            self._on_hangup()
        elif isinstance(message, Offer):
            self._on_offer(message)
        elif isinstance(message, ANSWERS):
            waiting = self._waiting.get(message.exchange)
            if waiting is not None and not waiting.done():
                waiting.set_result(message)
