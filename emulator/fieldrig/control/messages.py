"""Control messages between a rig, its processes and its tools: JSON over Zenoh.

Keys, all under `fieldrig/<rig>/`:

    rig/<verb>                queries to the rig: status, join, stop, restart, pause, run, step
    process/<name>/status     query to one process; `brief` for what can be asked all the time
    device/<name>/<verb>      queries to the process that hosts the device: keys, front, get, set, faults, its own
    bus/<name>/<verb>         queries to the process that runs the bus: status, conditions, faults ...
    end/<bus>/<device>/<verb> queries to the process that hosts the device: about its end of a bus (`end_questions`)
    alive/<process>           liveliness token: gone the instant the process is
    ready/<process>           published once by a process whose devices have started
    notice/<part>             published by a process: a fault or a condition of a bus or device begins or ends
    help/<name>               query to the rig: the connections of a bus or device, and lines that reach it
    event                     events of the rig
    record/<process>/<id>     batches of recorded values, in binary (`fieldrig.recording`)
    recorder/<owner>          liveliness token of a reader of recordings
    trace/<bus>, watch/<bus>  batches of messages, as data and as text; only while there is a listener

Zenoh calls back on threads of its own; everything here is handed to the loop.
"""

import asyncio
import json
import logging
import time
from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from queue import Empty, Full, Queue
from typing import Any, Final, NoReturn, Self

import zenoh

from fieldrig.control.endpoint import PATIENCE_S, close, connect
from fieldrig.control.questions import MOST_QUESTIONS, Questions
from fieldrig.errors import ControlError
from fieldrig.loop.pace import Pace
from fieldrig.outside.untrusted import MalformedError, field, read_json, shown

VERSION: Final = 1
"""Version of the messages; `status` reports it."""

log = logging.getLogger(__name__)

MOMENT_S: Final = 0.1
LONGEST_MESSAGE: Final = 64 << 20
"""Longest answer or published message in bytes, such as a batch; queries have the reader's own limit."""
LONGEST_REFUSAL: Final = 8_000  # characters
MOST_WAITING: Final = 10_000
"""Messages that may wait for a tool to read them."""
MOST_QUERIES: Final = 1_000
"""Queries that one process answers at a time; further ones are refused.  As many may wait (`questions`)."""

Answer = Callable[[str, Any], Awaitable[Any]]
"""Handles a query, given the last part of its key (the verb) and its payload.

A ControlError is the negative answer.
"""


def key(rig: str, *parts: str) -> str:
    return "/".join(("fieldrig", rig, *parts))


TIMED_OUT: Final = b"Timeout"
"""Zenoh's own answer for a process that is there and does not answer in time."""


KINDS_OF_PARTS: Final = ("device", "bus", "process", "condition", "help")
"""The words that stand before the name of a part in the path of a question."""


class NoAnswerError(ControlError):
    """The rig is running, but no part of it answers this question."""


class Control:
    """One session under asyncio.  Call all methods in the loop's thread."""

    def __init__(self, session: zenoh.Session, rig: str) -> None:
        self.session, self.rig = session, rig
        self._loop = asyncio.get_running_loop()
        self._kept: list[Any] = []  # what is declared lives as long as its object
        self._tasks: set[asyncio.Task[None]] = set()
        self._around: dict[str, Callable[[], object]] = {}
        self._is_open = True
        self._samples = 0
        """Published messages that were handed over, and not handled yet."""
        self._questions: Questions[tuple[zenoh.Query, str, Answer]] = Questions(
            "control endpoint", self._hand_over, lambda question: self._start(*question)
        )

    def keep(self, pace: Pace) -> None:
        """Answer at this pace from now on."""
        self._questions.pace = pace

    def limits(self) -> dict[str, float]:
        """Return how often each limit was reached, by name."""
        return self._questions.reached.figures()

    def serve(self, path: str, answer: Answer) -> None:
        """Answer the queries to `path`, which ends in a verb, or in `*` for any verb."""
        prefix = key(self.rig, path).rpartition("/")[0]  # the asker's key may have stars in it, an answer's may not

        def on_query(query: zenoh.Query) -> None:
            if not self._questions.put((query, prefix, answer)):
                with query:
                    _refuse(query, f"{MOST_QUESTIONS} questions wait for their answers", "ask again later")

        self._keep(self.session.declare_queryable(key(self.rig, path), _directly(on_query)))

    def around(self, verbs: Sequence[str], look: Callable[[], object]) -> None:
        """Call `look` before and after each question with one of these verbs is answered."""
        self._around |= dict.fromkeys(verbs, look)

    def publish(self, path: str, message: Any) -> None:
        """Publish a message for all listeners."""
        self.session.put(key(self.rig, path), json.dumps(message))

    def listen_to(self, path: str, handler: Callable[[str, Any], None]) -> Callable[[], None]:
        """Call `handler(last key part, message)` for every published message.  Return what ends it."""

        def on_sample(sample: zenoh.Sample) -> None:
            try:
                message = read_json(sample.payload.to_bytes(), LONGEST_MESSAGE, takes_nan=True)
            except MalformedError as fault:
                log.debug("%s: %s", sample.key_expr, fault)
            else:
                self._hand_over_message(handler, _last_part(sample.key_expr), message)

        return self._subscribe(path, on_sample)

    def listen_to_bytes(self, path: str, handler: Callable[[str, bytes], None]) -> Callable[[], None]:
        """Do the same with what is published in binary, as it is."""

        def on_sample(sample: zenoh.Sample) -> None:
            self._hand_over_message(handler, _last_part(sample.key_expr), sample.payload.to_bytes())

        return self._subscribe(path, on_sample)

    def _subscribe(self, path: str, on_sample: Callable[[zenoh.Sample], None]) -> Callable[[], None]:
        subscriber: Any = self.session.declare_subscriber(key(self.rig, path), _directly(on_sample))
        self._keep(subscriber)

        def end() -> None:
            if subscriber in self._kept:
                self._kept.remove(subscriber)
                subscriber.undeclare()

        return end

    def outlet(self, path: str) -> "Outlet":
        """Return a publisher of binary messages that gives way to all others, and drops what it cannot send at once."""
        publisher = self.session.declare_publisher(
            key(self.rig, path),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.DATA_LOW,
        )
        return Outlet(publisher)

    def show_life(self, path: str) -> Callable[[], None]:
        """Announce presence at `path` for as long as this process lives, or until the returned function is called."""
        token = self.session.liveliness().declare_token(key(self.rig, path))
        self._keep(token)
        return _ending(token)

    def watch_life(self, path: str, handler: Callable[[str, bool], None]) -> None:
        """Call `handler(last key part, is alive)` for everything that is present, appears or disappears."""

        def on_sample(sample: zenoh.Sample) -> None:
            is_alive = sample.kind == zenoh.SampleKind.PUT
            self._hand_over(handler, _last_part(sample.key_expr), is_alive)

        life = self.session.liveliness()
        self._keep(life.declare_subscriber(key(self.rig, path), _directly(on_sample), history=True))

    def stream(self, path: str, on_listeners: Callable[[bool], None]) -> "Stream":
        """Return a publisher.  `on_listeners` is called now, and whenever there may be more or fewer listeners."""
        stream = Stream(self.session.declare_publisher(key(self.rig, path)), on_listeners)
        on_matching = _directly(lambda _status: self._hand_over(stream.look))
        self._keep(stream, stream.publisher.declare_matching_listener(on_matching))
        stream.look()
        return stream

    async def ask(self, path: str, message: Any, timeout_s: float) -> Any:
        """Return the answer to one query.  ControlError if it is negative, or if there is none in time."""
        for reply in await self._replies(path, message, timeout_s):
            return _message_of(reply, path)
        raise _no_answer(path)

    async def ask_bytes(self, path: str, message: Any, timeout_s: float) -> bytes:
        """Return the answer to a query that is answered in binary.  ControlError as for `ask`."""
        for reply in await self._replies(path, message, timeout_s):
            return reply.ok.payload.to_bytes() if reply.ok is not None else _refusal(reply, path)
        raise _no_answer(path)

    async def ask_all(self, path: str, timeout_s: float) -> dict[str, Any]:
        """Return every positive answer to a path with a `*`, by the key part in its place."""
        return _by_star(path, await self._replies(path, None, timeout_s))

    async def _replies(self, path: str, message: Any, timeout_s: float) -> list[zenoh.Reply]:
        replies: list[zenoh.Reply] = []
        answered: asyncio.Future[None] = self._loop.create_future()

        def settle() -> None:
            if not answered.done():
                answered.set_result(None)

        handler = _directly(
            lambda reply: self._hand_over(replies.append, reply),
            lambda: self._hand_over(settle),
        )
        self.session.get(key(self.rig, path), handler, payload=json.dumps(message), timeout=timeout_s)
        await answered
        return replies

    async def close(self) -> None:
        self._is_open = False
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._kept.clear()
        close(self.session)

    def _keep(self, *declared: Any) -> None:
        self._kept.extend(declared)

    def _hand_over(self, action: Callable[..., object], *arguments: Any) -> None:
        """Pass a call from a Zenoh thread to the loop, which may be gone at the end of the process."""
        if self._is_open:
            try:
                self._loop.call_soon_threadsafe(action, *arguments)
            except RuntimeError:
                self._is_open = False

    def _hand_over_message(self, handler: Callable[[str, Any], None], name: str, message: Any) -> None:
        """Pass a published message to the loop, unless `MOST_WAITING` wait there."""
        if self._samples >= MOST_WAITING:
            what = f"{MOST_WAITING} published messages wait; another one is dropped"
            self._questions.reached.note("messages over the limit", what)
            return
        self._samples += 1
        self._hand_over(self._handle, handler, name, message)

    def _handle(self, handler: Callable[[str, Any], None], name: str, message: Any) -> None:
        self._samples -= 1
        handler(name, message)

    def _start(self, query: zenoh.Query, prefix: str, answer: Answer) -> None:
        if len(self._tasks) >= MOST_QUERIES:
            with query:
                _refuse(query, f"{MOST_QUERIES} questions wait for their answers", "ask again later")
            return
        look = self._around.get(_last_part(query.key_expr))
        if look is not None:
            look()
        task = self._loop.create_task(_answer(query, prefix, answer, self._questions.pace))
        if look is not None:
            task.add_done_callback(lambda _task: look())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


class Outlet:
    """A publisher of binary messages."""

    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher

    def put(self, data: bytes) -> None:
        self._publisher.put(data)

    def end(self) -> None:
        _ending(self._publisher)()


class Stream:
    """A publisher that knows whether it has listeners."""

    def __init__(self, publisher: zenoh.Publisher, on_listeners: Callable[[bool], None]) -> None:
        self.publisher = publisher
        self._on_listeners = on_listeners

    def put(self, message: str) -> None:
        self.publisher.put(message)

    def look(self) -> None:
        """Return whether there is a listener now.

        Zenoh reports a listener some milliseconds late.  A listener that was there before an answer was given is known
        to this session when the answer arrives.
        """
        # The binding calls it a bool in its stubs; it is a MatchingStatus.
        status: Any = self.publisher.matching_status
        self._on_listeners(status.matching)


async def _answer(query: zenoh.Query, prefix: str, answer: Answer, pace: Pace | None) -> None:
    asked_ns = time.monotonic_ns()
    try:
        await _reply(query, prefix, answer)
    finally:
        if pace is not None:
            pace.answered(asked_ns)


async def _reply(query: zenoh.Query, prefix: str, answer: Answer) -> None:
    verb = _last_part(query.key_expr)
    with query:
        try:
            payload = query.payload
            message = read_json(payload.to_bytes()) if payload is not None else None
        except MalformedError as cause:
            _refuse(query, f"not understood: {cause}")
            return
        try:
            reply = await answer(verb, message)
        except ControlError as refusal:
            _refuse(query, refusal.what, refusal.remedy)
        except ValueError as cause:
            _refuse(query, f"not understood: {cause}")
        else:
            query.reply(f"{prefix}/{verb}", reply if isinstance(reply, bytes) else json.dumps(reply))


def _refuse(query: zenoh.Query, what: str, remedy: str = "") -> None:
    query.reply_err(json.dumps({"what": what[:LONGEST_REFUSAL], "remedy": remedy[:LONGEST_REFUSAL]}))


def _nothing() -> None: ...


class Client:
    """A tool's connection to the rig at an endpoint, without an event loop."""

    def __init__(self, endpoint: str, patience_s: float = PATIENCE_S) -> None:
        self.session = connect(endpoint, patience_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        close(self.session)

    def ask(self, path: str, message: Any = None, timeout_s: float = 5.0) -> Any:
        """Return the answer.  ControlError if it is negative or there is none."""
        for reply in self.session.get(key("*", path), payload=json.dumps(message), timeout=timeout_s):
            return _message_of(reply, path)
        raise _no_answer(path)

    def ask_all(self, path: str, message: Any = None, timeout_s: float = 5.0) -> dict[str, Any]:
        """Return every positive answer to a path with a `*`, by the key part in its place."""
        replies = self.session.get(key("*", path), payload=json.dumps(message), timeout=timeout_s)
        return _by_star(path, replies)

    def inbox(self, paths: Sequence[str], on_full: Callable[[], None] = _nothing) -> "Iterator[tuple[str, Any] | None]":
        """Yield what is published at the paths, as last key part and message; None when nothing came for a moment.

        `MOST_WAITING` messages wait at most: a further one is dropped, and `on_full` is called, in another thread.
        """
        waiting: Queue[tuple[str, bytes]] = Queue(MOST_WAITING)

        def on_sample(sample: zenoh.Sample) -> None:
            try:
                waiting.put_nowait((_last_part(sample.key_expr), sample.payload.to_bytes()))
            except Full:  # a slow reader misses some, and sees how many by the numbers of the batches
                on_full()

        subscribers = [self.session.declare_subscriber(key("*", path), _directly(on_sample)) for path in paths]
        while subscribers:
            try:
                name, message = waiting.get(timeout=MOMENT_S)
            except Empty:
                yield None
            else:
                try:
                    yield name, read_json(message, LONGEST_MESSAGE, takes_nan=True)
                except MalformedError as fault:
                    log.debug("%s: %s", name, fault)


def _by_star(path: str, replies: Iterable[zenoh.Reply]) -> dict[str, Any]:
    index = key("*", path).split("/").index("*", 2)
    return {str(reply.ok.key_expr).split("/")[index]: _answer_of(reply.ok) for reply in replies if reply.ok is not None}


def _answer_of(sample: zenoh.Sample) -> Any:
    try:
        return read_json(sample.payload.to_bytes(), LONGEST_MESSAGE, takes_nan=True)
    except MalformedError as cause:
        raise ControlError(f"{sample.key_expr}: the answer cannot be understood: {cause}") from cause


def _message_of(reply: zenoh.Reply, path: str) -> Any:
    return _answer_of(reply.ok) if reply.ok is not None else _refusal(reply, path)


def _refusal(reply: zenoh.Reply, path: str) -> NoReturn:
    """Raise the ControlError that a negative answer holds."""
    error = reply.err
    body = error.payload.to_bytes() if error is not None else b""
    if body == TIMED_OUT:
        raise _no_answer(path)
    try:
        refusal = read_json(body)
        what, remedy = field(refusal, "what", str), field(refusal, "remedy", str)
    except MalformedError:
        what, remedy = shown(body.decode(errors="replace")), ""
    raise ControlError(what, remedy)


def _no_answer(path: str) -> NoAnswerError:
    """Return the error for a question that nothing answers, by the name of the part that should."""
    kind, _, rest = path.partition("/")
    if kind not in KINDS_OF_PARTS:
        return NoAnswerError("the rig does not answer", "it may be stopping, or too busy")
    name = rest.partition("/")[0]
    return NoAnswerError(
        f"{name} does not answer: it has not started, it hangs, or its process died", "look at `fieldrig status`"
    )


def _ending(declared: Any) -> Callable[[], None]:
    """Return a function that takes back a declaration, unless the session is closed already."""

    def end() -> None:
        with suppress(zenoh.ZError):
            declared.undeclare()

    return end


def _directly(
    callback: Callable[[Any], None], drop: Callable[[], None] | None = None
) -> "zenoh.handlers.Callback[Any]":
    """Make Zenoh call back on its own thread, instead of on a further thread for every declaration."""
    return zenoh.handlers.Callback(callback, drop, indirect=False)


def _last_part(key_expr: zenoh.KeyExpr) -> str:
    return str(key_expr).rpartition("/")[2]
