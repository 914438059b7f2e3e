"""A node whose device lives in a process of its own, under virtual time.

Parent and child talk over a private pipe; messages cross it as their bus encodes them.
"""

import multiprocessing
import sys
from collections.abc import Callable, Iterable, Mapping
from multiprocessing.connection import Connection
from typing import Any

from fieldrig.bus import Bus
from fieldrig.config.entries import DeviceEntry
from fieldrig.coverage import collecting
from fieldrig.device import Value
from fieldrig.errors import RigError
from fieldrig.points.watched_points import Change
from fieldrig.storage.store import Store
from fieldrig.virtual.node import BusName, Deliveries, LocalNode, Outbox, Stepped


class RemoteNode:
    """A node in a process of its own; `stop` ends the process.

    `begin` and `finish` are the two halves of a step, so that all such nodes step at the same time.
    """

    def __init__(self, entry: DeviceEntry, seed: int, store: Store, buses: Mapping[BusName, Bus[Any]]) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._encode = {name: bus.encode for name, bus in buses.items()}
        self._decode = {name: bus.decode for name, bus in buses.items()}
        own_buses = {name: buses[name] for names in entry.links.values() for name in names}
        self._name = entry.name
        self._process = context.Process(
            target=_serve, args=(theirs, entry, seed, store, own_buses), name=f"fieldrig {entry.name}", daemon=True
        )
        self._process.start()
        theirs.close()
        self._is_built = False

    def begin(self, until_ns: int, deliveries: Deliveries) -> None:
        self._receive_ready()
        encode = self._encode
        self._pipe.send(("step", until_ns, [(bus, encode[bus](message)) for bus, message in deliveries]))

    def finish(self) -> Stepped:
        self._receive_ready()
        listens, sent, next_ns, notes = self._receive()
        decode = self._decode
        return Stepped(listens, [(bus, decode[bus](data)) for bus, data in sent], next_ns, notes)

    def keys(self) -> dict[str, str]:
        return dict(self._ask("keys"))

    def facts(self) -> dict[str, dict[str, Any]]:
        return dict(self._ask("facts"))

    def values(self, now_ns: int, keys: Iterable[str] | None = None) -> dict[str, Value]:
        return dict(self._ask("values", now_ns, None if keys is None else list(keys)))

    def front(self, now_ns: int) -> dict[str, Any]:
        return dict(self._ask("front", now_ns))

    def get(self, now_ns: int, key: str) -> Value:
        value: Value = self._ask("get", now_ns, key)
        return value

    def set(self, key: str, value: Value) -> None:
        self._ask("set", key, value)

    def answer(self, question: str, message: Any) -> Any:
        return self._ask("answer", question, message)

    def add_fault(self, fault: Mapping[str, Any], above: int = 0) -> int:
        number: int = self._ask("add_fault", dict(fault), above)
        return number

    def begin_fault(self, number: int) -> None:
        self._ask("begin_fault", number)

    def clear_fault(self, number: int) -> None:
        self._ask("clear_fault", number)

    def faults(self, now_ns: int) -> Mapping[int, Mapping[str, Any]]:
        return dict(self._ask("faults", now_ns))

    def watch(self, now_ns: int, key: str) -> None:
        self._ask("watch", now_ns, key)

    def unwatch(self, key: str) -> None:
        self._ask("unwatch", key)

    def changes(self) -> list[Change]:
        return list(self._ask("changes"))

    def switch(self, now_ns: int, is_on: bool) -> None:
        self._ask("switch", now_ns, is_on)

    def reseed(self, seed: int) -> None:
        self._ask("reseed", seed)

    def stop(self) -> None:
        if self._process.is_alive():
            try:
                self._ask("stop")
            except RigError:
                self._process.kill()
        self._process.join()
        self._process.close()
        self._pipe.close()

    def _ask(self, *request: Any) -> Any:
        self._receive_ready()
        self._pipe.send(request)
        return self._receive()

    def _receive_ready(self) -> None:
        """Wait until the process has built its device, which is its first answer."""
        if not self._is_built:
            self._receive()
            self._is_built = True

    def _receive(self) -> Any:
        try:
            outcome, answer = self._pipe.recv()
        except (EOFError, ConnectionResetError) as cause:
            raise RigError(f"the process of {self._name} is gone", "its traceback is above") from cause
        if outcome == "failed":
            raise answer
        return answer


def _serve(pipe: Connection, entry: DeviceEntry, seed: int, store: Store, buses: Mapping[BusName, Bus[Any]]) -> None:
    """Build the device in the child, then answer until the pipe closes."""
    try:
        node = LocalNode(entry, seed, store, Outbox(buses))
    except RigError as fault:
        pipe.send(("failed", fault))
        sys.exit(1)
    pipe.send(("done", None))
    encode = {name: bus.encode for name, bus in buses.items()}
    decode = {name: bus.decode for name, bus in buses.items()}

    def step(until_ns: int, deliveries: list[tuple[BusName, bytes]]) -> None:
        node.react(until_ns, [(bus, decode[bus](data)) for bus, data in deliveries])

    def finish() -> tuple[Any, ...]:
        listens, sent, next_ns, notes = node.finish()
        return listens, [(bus, encode[bus](message)) for bus, message in sent], next_ns, notes

    verbs: dict[str, Callable[..., Any]] = {
        "keys": node.keys,
        "facts": node.facts,
        "values": node.values,
        "front": node.front,
        "get": node.get,
        "set": node.set,
        "answer": node.answer,
        "add_fault": node.add_fault,
        "begin_fault": node.begin_fault,
        "clear_fault": node.clear_fault,
        "faults": node.faults,
        "watch": node.watch,
        "unwatch": node.unwatch,
        "changes": node.changes,
        "switch": node.switch,
        "reseed": node.reseed,
        "stop": node.stop,
    }
    while True:
        try:
            verb, *arguments = pipe.recv()
        except EOFError:  # the rig is gone
            return
        if verb == "step":
            step(*arguments)
            pipe.send(("done", finish()))
            collecting.flush_now_and_then()
            continue
        collecting.flush()  # before the rig knows that it is done
        try:
            pipe.send(("done", verbs[verb](*arguments)))
        except RigError as fault:
            pipe.send(("failed", fault))
        if verb == "stop":
            return
