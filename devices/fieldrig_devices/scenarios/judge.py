"""Judges properties from changes of places and from time.

It is passive, so it judges a rig, a branch of one and a recording alike.  It looks at each change, and at the end of
each instant at which something happens.  Nothing is sampled: a pulse that is over in the same instant is seen.
"""

from collections.abc import Iterable, Mapping, Sequence

from fieldrig.device import Value
from fieldrig_devices.scenarios.property import Property, Violation
from fieldrig_devices.scenarios.watches import Found, Recovery, Watch, watch_of

Values = Mapping[str, Value]


class Judge:
    """Call `change` with each change, and `look` at the end of each instant, in the order of time.

    Times are nanoseconds from the begin of the scenario.
    """

    def __init__(self, properties: Sequence[Property], values: Values) -> None:
        """`values` are those of all places at the begin.  TypeError for a property that cannot be judged with them."""
        self.values: dict[str, Value] = dict(values)
        self.violations: list[Violation] = []
        self._open: list[Watch] = [watch_of(one) for one in properties]
        self._of_place: dict[str, list[Watch]] = {}
        for watch in self._open:
            for place in watch.rule.places:
                self._of_place.setdefault(place, []).append(watch)
        self.look(0)

    def change(self, at_ns: int, place: str, value: Value) -> None:
        """Note a change, and judge what depends on it."""
        self.values[place] = value
        self._judge(at_ns, self._of_place.get(place, ()))

    def look(self, at_ns: int, changed: Values | None = None) -> None:
        """Judge everything, with values that may have changed without an event."""
        if changed is not None:
            news = {place: value for place, value in changed.items() if self.values.get(place) != value}
            if not news and not self._is_due(at_ns):
                return  # as it was at the last look
            self.values.update(news)
        self._judge(at_ns, tuple(self._open))

    def _is_due(self, at_ns: int) -> bool:
        return any(watch.due_ns is not None and at_ns > watch.due_ns for watch in self._open)

    def healed(self, at_ns: int) -> None:
        """Note that all actions are over, and that there is no fault any more."""
        for watch in self._open:
            watch.heal(at_ns)
        self.look(at_ns)

    def hurt(self) -> None:
        """Note that more happens after all was over: whether the machine comes back is judged after that."""
        for watch in self._open:
            watch.hurt()

    @property
    def recovery_ns(self) -> int | None:
        """The latest instant at which the machine has to have come back; None if it is not waited for."""
        dues = (watch.due_ns for watch in self._open if isinstance(watch, Recovery))
        return max((due for due in dues if due is not None), default=None)

    @property
    def unjudged(self) -> tuple[str, ...]:
        """The properties for whose judgement the faults have not ended."""
        return tuple(one.rule.name for one in self._open if isinstance(one, Recovery) and not one.is_judged)

    def end(self, at_ns: int) -> None:
        """Judge what had to happen until now."""
        self.look(at_ns)
        for watch in tuple(self._open):
            self._note(watch, watch.missed(at_ns))

    def _judge(self, at_ns: int, watches: Iterable[Watch]) -> None:
        for watch in tuple(watches):
            if watch in self._open:
                self._note(watch, watch.look(at_ns, self.values))

    def _note(self, watch: Watch, found: Found) -> None:
        if found is None:
            return
        at_ns, what = found
        self._open.remove(watch)
        values = tuple((place, self.values[place]) for place in watch.rule.places)
        self.violations.append(Violation(watch.rule.name, at_ns, what, values))
