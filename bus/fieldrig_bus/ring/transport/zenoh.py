"""A ring over Zenoh, also between machines.

It has sessions of its own, in a star around the master's: without scouting, gossip, time stamps and shared memory, with
one priority and low latency.  One put per cycle reaches all processes, on a key that all of them know; for a key with a
wildcard Zenoh would determine the receivers every time.  Only while a process stands still, the others get a put each.
One message comes back from each process.  A liveliness token announces a process and its stations; it disappears with
the process.  At the centre, the messages that come back wait in Zenoh for the next cycle.  In the process of a station,
threads of the event loop wait for cycles and handle them.  That takes a sixth less work than waking the loop, or
than being called by Zenoh, which changes threads when a callback sends something.
"""

import asyncio
import logging
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from typing import Any, Final

import zenoh
from pydantic import Field

from fieldrig.bus import Attachment
from fieldrig.control import endpoint
from fieldrig.errors import BusError
from fieldrig.loop.threaded_loop import ThreadedLoop
from fieldrig.outside.shared_token import TOKEN_VARIABLE
from fieldrig.settings import Settings
from fieldrig.system.own_files import remove_socket
from fieldrig_bus.ring.transport.centre import MOST_BEHIND, Centre
from fieldrig_bus.ring.transport.rack import Rack
from fieldrig_bus.ring.transport.wire import Stations

log = logging.getLogger(__name__)

ALL, OUT, BACK, HERE = "all", "out", "back", "here"
OBSERVER: Final = "observer"
LONGEST_PATH: Final = 100
"""Longest path of a Unix socket.  The limit of the system is 108, and Zenoh adds some characters for its lock."""
MOST_OUT: Final = 192
MOST_BACK: Final = 8_192
"""Messages from stations that may wait: more than are under way to and from processes that stand still."""
TUNED: Final[dict[str, Any]] = {
    "transport/unicast/qos/enabled": False,
    "transport/unicast/lowlatency": True,
    "transport/link/rx/buffer_size": 2
    * 65_535,  # the message that is read, and the next one; Zenoh clears a buffer that it allocates
    "transport/link/tx/lease": 1_000,  # ms: a process that stands still must not fill the socket of the centre
}
ENVIRONMENT: Final[Mapping[str, str]] = {
    "ZENOH_RUNTIME": "(acc: (handover: rx), net: (handover: rx), rx: (worker_threads: 1))"
}
"""Environment of a process with an end of the ring.  The thread that reads a message also handles it, which halves the
wake-ups.  With `app` or `tx` in it too, messages are lost in bursts."""
EXCHANGE_NS: Final = 120_000
"""Measured: 1.3 cores with 41 processes at 4 ms (`Bus.exchange_ns`)."""
LOOK_AGAIN_NS: Final = 1_000_000_000
"""Time between two questions for tokens, while something comes from a process that has none."""
PATIENT: Final[dict[str, Any]] = {
    "connect/timeout_ms": -1,
    "connect/exit_on_failure": False,
    "connect/retry": {"period_init_ms": 20, "period_max_ms": 100, "period_increase_factor": 1.5},
}


class ZenohSpokes:
    """The centre's end."""

    def __init__(self, session: zenoh.Session, centre: Centre) -> None:
        self._session, self._centre, self._loop = session, centre, centre.loop
        self._here: dict[str, dict[tuple[int, int], Stations]] = {}
        """The tokens of each process by age; the newest one is valid."""
        self._all = self._publisher(ALL)
        self._each: dict[str, zenoh.Publisher] = {}
        self._looked_ns = -LOOK_AGAIN_NS
        self._back = session.declare_subscriber(f"{BACK}/*", zenoh.handlers.FifoChannel(MOST_BACK))
        self._life = session.liveliness().declare_subscriber(f"{HERE}/**", _directly(self._on_life), history=True)

    def spread(self, message: bytes, hung: Collection[str]) -> None:
        if not hung:
            self._all.put(message)
            return
        for process in self._here.keys() - hung:
            if process not in self._each:
                self._each[process] = self._publisher(f"{OUT}/{process}")
            self._each[process].put(message)

    def gather(self) -> Iterator[tuple[str, bytes]]:
        while (sample := self._back.try_recv()) is not None:
            process = str(sample.key_expr).rpartition("/")[2]
            if process not in self._here:
                self._look_again()
            yield process, sample.payload.to_bytes()

    def _look_again(self) -> None:
        """Ask for all tokens: a connection whose end is noticed late takes the same token of the next one with it."""
        now_ns = time.monotonic_ns()
        if now_ns - self._looked_ns >= LOOK_AGAIN_NS:
            self._looked_ns = now_ns
            self._session.liveliness().get(f"{HERE}/**", _directly(self._on_found))

    def close(self) -> None:
        endpoint.close(self._session)

    def _publisher(self, key: str) -> zenoh.Publisher:
        return self._session.declare_publisher(key, express=True, congestion_control=zenoh.CongestionControl.BLOCK)

    def _on_here(self, key: str, is_alive: bool) -> None:
        """A token has appeared or is gone.  Older tokens may be reported after newer ones."""
        try:
            _, process, born, turn, stations = key.split("/")
            age = int(born), int(turn)
        except ValueError:
            log.debug("not a token of a ring: %s", key)
            return
        tokens = self._here.setdefault(process, {})
        if is_alive:
            tokens[age] = _stations_of(stations)
        else:
            tokens.pop(age, None)
        if tokens:
            self._centre.announce(process, tokens[max(tokens)])
        else:
            del self._here[process]
            self._centre.lose(process)

    def _on_found(self, reply: zenoh.Reply) -> None:
        """Called on a thread of Zenoh."""
        if reply.ok is not None:
            _hand_over(self._loop, self._on_here, str(reply.ok.key_expr), True)

    def _on_life(self, sample: zenoh.Sample) -> None:
        """Called on a thread of Zenoh."""
        _hand_over(self._loop, self._on_here, str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)


class ZenohLine:
    """A process's connection to the centre.  Zenoh connects, and reconnects after a failure."""

    def __init__(self, session: zenoh.Session, process: str, rack: Rack[Any]) -> None:
        self._session, self._process = session, process
        self._born, self._tokens = time.time_ns(), 0
        self._token: Any = None
        self._rack = rack
        self._is_open = True
        self._back = session.declare_publisher(
            f"{BACK}/{process}", express=True, congestion_control=zenoh.CongestionControl.BLOCK
        )
        rack.connect(self._announce, self._back.put)
        assert isinstance(rack.loop, ThreadedLoop)
        self._lock = rack.loop.lock
        for key in (ALL, f"{OUT}/{process}"):
            out = session.declare_subscriber(key, zenoh.handlers.FifoChannel(MOST_OUT))
            rack.loop.start_thread(f"ring:{key}", partial(self._receive, out.recv))

    def close(self) -> None:
        self._is_open = False
        self._rack.disconnect()
        endpoint.close(self._session)

    def _announce(self, stations: Stations) -> None:
        """Declare the new token before undeclaring the old one."""
        former, self._token = self._token, None
        self._tokens += 1
        if stations:
            key = f"{HERE}/{self._process}/{self._born}/{self._tokens}/{_token_of(stations)}"
            self._token = self._session.liveliness().declare_token(key)
        if former is not None:
            former.undeclare()

    def _receive(self, receive: Callable[[], zenoh.Sample]) -> None:
        """Run one thread of the loop: hand every message to the rack while the lock is held."""
        lock, on_spread = self._lock, self._rack.on_spread
        while True:
            try:
                message = receive().payload.to_bytes()
            except zenoh.ZError:  # the session was closed
                return
            with lock:
                if not self._is_open:
                    return
                on_spread(message)


class ZenohSettings(Settings):
    """Settings of a ring over Zenoh."""

    endpoint: str | None = Field(
        default=None,
        pattern=r"^tcp/[^/\s]+:[0-9]{1,5}$",
        examples=["tcp/127.0.0.1:7450"],
        description="where the master's process listens; left out: a Unix socket in the run folder",
    )


class ZenohCarrier:
    """Connects the processes of one ring over Zenoh."""

    def __init__(self, name: str, endpoint: str | None, most_behind: int = MOST_BEHIND) -> None:
        """`name` is that of the bus; `endpoint` is where the master's process listens.

        `most_behind` is less than `MOST_OUT`, because Zenoh blocks the centre where a channel is full.
        """
        self.name, self._endpoint, self.most_behind = name, endpoint, most_behind

    def reach(self, at: Attachment, rack: Rack[Any]) -> ZenohLine:
        # A listening endpoint of its own could be found by others.
        places = {"listen/endpoints": [], "connect/endpoints": [self._place(at)]}
        return ZenohLine(endpoint.open_session({"mode": "peer", **places, **PATIENT, **TUNED}), at.process, rack)

    def hold(self, at: Attachment, centre: Centre) -> ZenohSpokes:
        address = self._place(at)
        if not endpoint.is_guarded(address):
            remedy = f"set a token in the environment variable {TOKEN_VARIABLE}, or listen on 127.0.0.1"
            raise BusError(f"{self.name}: {address} can be reached from other machines", remedy)
        if endpoint.is_answered(address):
            raise BusError(f"{self.name}: another program listens on {address}", "a ring has one master")
        if self._endpoint is None:  # the rig's lock says that no living rig owns the folder
            remove_socket(at.path(f"{self.name}.zenoh"))
        try:
            session = endpoint.open_session({"mode": "peer", "listen/endpoints": [address], **TUNED})
        except zenoh.ZError as cause:
            reason = str(cause).partition(" at /")[0]
            raise BusError(f"{self.name}: cannot listen on {address}: {reason}", "choose another `endpoint`") from cause
        return ZenohSpokes(session, centre)

    def _place(self, at: Attachment) -> str:
        if self._endpoint is not None:
            return self._endpoint
        path = str(at.path(f"{self.name}.zenoh"))
        if len(path) > LONGEST_PATH:
            raise BusError(
                f"{self.name}: the path of its socket is too long: {path}", "set `endpoint` or the rig's `run`"
            )
        return f"unixsock-stream/{path}"


def _token_of(stations: Stations) -> str:
    """The stations as part of a key.  Names consist of lower-case letters, digits, _ and -, which Zenoh allows."""
    return ";".join(
        f"{name}={OBSERVER if addresses is None else ','.join(map(str, addresses))}" for name, addresses in stations
    )


def _stations_of(token: str) -> Stations:
    """The inverse of `_token_of`.  A station that is not understood is left out."""
    stations: list[tuple[str, list[int] | None]] = []
    for station in token.split(";"):
        name, _, addresses = station.partition("=")
        if addresses == OBSERVER:
            stations.append((name, None))
        elif all(address.isdecimal() for address in addresses.split(",") if address):
            stations.append((name, [int(address) for address in addresses.split(",") if address]))
        else:
            log.debug("not a station of a ring: %s", station)
    return stations


def _hand_over(loop: asyncio.AbstractEventLoop, action: Callable[..., None], *arguments: Any) -> None:
    """Call an action in the event loop, which may be closed already at the end of the process."""
    try:
        loop.call_soon_threadsafe(action, *arguments)
    except RuntimeError as fault:
        log.debug("%s", fault)


def _directly(callback: Callable[[Any], None]) -> "zenoh.handlers.Callback[Any]":
    """A callback on Zenoh's own thread, instead of on a further thread for every declaration."""
    return zenoh.handlers.Callback(callback, indirect=False)
