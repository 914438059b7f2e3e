"""The six events of ONn, which select the interrupt routine to run.

Source: manual 5.5; digest chapters 11 and 15.  Edges are detected once per control loop, while the enabling flag is
high, and kept until they are served.  Levels and positions are checked whenever a routine could begin, so a condition
that stays true keeps the main program from running, as the manual warns.  The lowest number is served first; routines
are not nested.
"""

from dataclasses import dataclass
from enum import IntEnum

from fieldrig_devices.arp.runtime.card import Card


class Edge(IntEnum):
    HIGH = 0
    LOW = 1
    RISING = 2
    FALLING = 3


@dataclass(slots=True)
class BitEvent:
    routine: int
    enable: int
    edge: Edge
    is_input: bool
    number: int
    level: int = 0
    is_pending: bool = False


@dataclass(frozen=True, slots=True)
class PositionEvent:
    routine: int
    enable: int
    axis: int
    is_above: bool
    variable: int


class Events:
    def __init__(self, card: Card) -> None:
        self._card = card
        self._armed: dict[int, BitEvent | PositionEvent] = {}

    def reset(self) -> None:
        self._armed.clear()

    def arm(self, number: int, event: BitEvent | PositionEvent) -> None:
        """Arm an event; it replaces an event of the same number at once."""
        if isinstance(event, BitEvent):
            event.level = self._level(event)
        self._armed[number] = event
        self._armed = dict(sorted(self._armed.items()))

    def disarm(self, number: int) -> None:
        self._armed.pop(number, None)

    def sample(self) -> None:
        """Detect edges, once per control loop."""
        for event in self._armed.values():
            if isinstance(event, BitEvent) and event.edge >= Edge.RISING:
                level = self._level(event)
                if level != event.level and self._card.F[event.enable] and level == (event.edge is Edge.RISING):
                    event.is_pending = True
                event.level = level

    def due(self) -> int | None:
        """The routine of the event to be served now, which then counts as served, or None."""
        for event in self._armed.values():
            if self._card.F[event.enable]:
                if self._is_true(event):
                    return event.routine
            elif isinstance(event, BitEvent):
                event.is_pending = False
        return None

    def _level(self, event: BitEvent) -> int:
        return (self._card.I if event.is_input else self._card.F)[event.number]

    def _is_true(self, event: BitEvent | PositionEvent) -> bool:
        if isinstance(event, PositionEvent):
            position, limit = self._card.position(event.axis), self._card.V[event.variable]
            return position > limit if event.is_above else position < limit
        if event.edge >= Edge.RISING:
            is_pending, event.is_pending = event.is_pending, False
            return is_pending
        return self._level(event) == (event.edge is Edge.HIGH)
