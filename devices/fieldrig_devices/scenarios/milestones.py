"""The milestones of actions: which conditions they wait for, and how often each has become true."""

from collections.abc import Iterator, Mapping

from fieldrig.device import Value
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.expression import expression_of


class _Waiting:
    """An action whose milestone has not been reached."""

    def __init__(self, act: Act) -> None:
        self.act, self.condition = act, expression_of(act.when)
        self._was, self._count = False, 0

    def is_reached(self, values: Mapping[str, Value]) -> bool:
        was, self._was = self._was, self.condition.holds(values)
        self._count += self._was and not was
        return self._count >= self.act.nth


class Milestones:
    """Call `look` with the values after each change, and take what is due from then on."""

    def __init__(self) -> None:
        self._waiting: list[_Waiting] = []
        self._reached: list[Act] = []

    def add(self, act: Act) -> None:
        """Wait for the milestone of an action.  ValueError for one that is no condition."""
        self._waiting.append(_Waiting(act))

    @property
    def waiting(self) -> tuple[Act, ...]:
        """The actions whose milestones have not been reached."""
        return tuple(each.act for each in self._waiting)

    @property
    def has_reached(self) -> bool:
        """True if there are actions for `reached`."""
        return bool(self._reached)

    def look(self, at_ns: int, values: Mapping[str, Value]) -> None:
        """Look at all conditions.  One that is true already counts as having become true."""
        for waiting in [each for each in self._waiting if each.is_reached(values)]:
            self._waiting.remove(waiting)
            self._reached.append(waiting.act._replace(at_ns=at_ns + waiting.act.at_ns, when="", nth=1))

    def reached(self) -> Iterator[Act]:
        """Yield the actions whose milestones have been reached since the last call, with their instants."""
        reached, self._reached = self._reached, []
        yield from reached
