"""The clients of the ports of a rig: members from outside, each at one bus or several.

They have the names that they have in real time, such as `tcp:1`, so a name may be at several buses.
"""

from collections.abc import Callable
from typing import Any

from fieldrig.bus import BusModel, Doors
from fieldrig.errors import RigError
from fieldrig.virtual.engine import Engine
from fieldrig.virtual.node import EventNode


class Clients:
    """The clients of a rig, in a block of `virtual_time`."""

    def __init__(self, engine: Engine, add: Callable[[str], EventNode], model: Callable[[str], BusModel[Any]]) -> None:
        """`add` adds a member from outside, or refuses it; `model` returns a bus, or raises ControlError."""
        self._engine, self._add, self._model = engine, add, model
        self._buses: dict[str, list[str]] = {}
        """The buses of each client."""

    @property
    def are_there(self) -> bool:
        """True if the rig has any client."""
        return bool(self._buses)

    @property
    def are_alone(self) -> bool:
        """True if whatever happens in the rig calls nothing outside but these clients."""
        engine = self._engine
        is_heard = engine.listeners or engine.instant_calls
        return not is_heard and not engine.watches and len(engine.outside) == len(self._buses)

    def has(self, member: str, bus: str) -> bool:
        """True if no client of this name can join the bus."""
        engine = self._engine
        is_other = member in engine.nodes or (member in engine.outside and member not in self._buses)
        return is_other or bus in self._buses.get(member, ())

    def join(self, member: str, bus: str) -> EventNode:
        """Add a client to a bus.  ControlError for an unknown bus, RigError if it has a member of this name."""
        engine, model = self._engine, self._model(bus)
        if self.has(member, bus):
            raise RigError(f"the bus {bus!r} already has a member {member!r}", "choose another name")
        node = engine.outside.get(member) or self._add(member)
        self._buses.setdefault(member, []).append(bus)
        model.join(member)
        return node

    def leave(self, member: str, bus: str) -> None:
        """Remove a client from a bus, with what it has sent and waits for the bus."""
        engine, buses = self._engine, self._buses[member]
        engine.take_from_outside()
        buses.remove(bus)
        self._model(bus).leave(member)
        if not buses:
            del self._buses[member]
            engine.remove(member)

    def on_doors(self, bus: str, call: Callable[[Doors], None]) -> None:
        """Call `call` with the effects of faults of a bus on its ports."""
        self._model(bus).on_doors(call)

    def waiting(self, member: str, bus: str) -> int:
        """Return how many messages of a client wait to be sent."""
        return self._model(bus).waiting(member)
