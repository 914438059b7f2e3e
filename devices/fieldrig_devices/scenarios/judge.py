"""Judges properties from changes of places and from time.

It is passive, so it judges a rig, a branch of one and a recording alike.  It looks at each change, and at the end of
each instant at which something happens.  Nothing is sampled: a pulse that is over in the same instant is seen.
"""

from collections.abc import Iterable, Mapping, Sequence

from fieldrig.device import Value
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.expression import Expression
from fieldrig_devices.scenarios.property import Kind, Property, Violation

Values = Mapping[str, Value]


class Judge:
    """Call `change` with each change, and `look` at the end of each instant, in the order of time.

    Times are nanoseconds from the begin of the scenario.
    """

    def __init__(self, properties: Sequence[Property], values: Values) -> None:
        """`values` are those of all places at the begin.  TypeError for a property that cannot be judged with them."""
        self.values: dict[str, Value] = dict(values)
        self.violations: list[Violation] = []
        self._open: list[_Watch] = [_watch_of(one) for one in properties]
        self._of_place: dict[str, list[_Watch]] = {}
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
        if changed:
            self.values.update(changed)
        self._judge(at_ns, tuple(self._open))

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
        dues = (watch.due_ns for watch in self._open if isinstance(watch, _Recovery))
        return max((due for due in dues if due is not None), default=None)

    def end(self, at_ns: int) -> None:
        """Judge what had to happen until now."""
        self.look(at_ns)
        for watch in tuple(self._open):
            self._note(watch, watch.missed(at_ns))

    def _judge(self, at_ns: int, watches: Iterable["_Watch"]) -> None:
        for watch in tuple(watches):
            if watch in self._open:
                self._note(watch, watch.look(at_ns, self.values))

    def _note(self, watch: "_Watch", found: tuple[int, str] | None) -> None:
        if found is None:
            return
        at_ns, what = found
        self._open.remove(watch)
        values = tuple((place, self.values[place]) for place in watch.rule.places)
        self.violations.append(Violation(watch.rule.name, at_ns, what, values))


Found = tuple[int, str] | None
"""The instant of a violation with its reason, or None."""


class _Watch:
    """One property on its way."""

    def __init__(self, rule: Property) -> None:
        self.rule = rule
        self.due_ns: int | None = None
        """The instant until which something has to happen."""

    def look(self, at_ns: int, values: Values) -> Found:
        raise NotImplementedError

    def heal(self, at_ns: int) -> None:
        """Nothing: most properties hold with faults as well."""

    def hurt(self) -> None:
        """Nothing, as above."""

    def missed(self, at_ns: int) -> Found:
        """Return what has not happened until the end of the scenario."""
        return self._late(self.due_ns) if self.due_ns is not None and self.due_ns <= at_ns else None

    def _late(self, due_ns: int) -> Found:
        raise NotImplementedError


class _Edge:
    """The instants at which an expression becomes true; without one, the begin."""

    def __init__(self, expression: Expression | None) -> None:
        self._expression, self._was = expression, False

    def rises(self, values: Values) -> bool:
        was, self._was = self._was, self._expression is None or self._expression.holds(values)
        return self._was and not was


class _Invariant(_Watch):
    """`always` and `never`; with a time, the condition may be wrong for that long."""

    def __init__(self, rule: Property) -> None:
        super().__init__(rule)
        self._begin, self._is_on = _Edge(rule.after), False

    def look(self, at_ns: int, values: Values) -> Found:
        self._is_on = self._is_on or self._begin.rises(values)
        if self.due_ns is not None and at_ns > self.due_ns:
            return self._late(self.due_ns)
        rule = self.rule
        if not self._is_on or rule.condition.holds(values) is (rule.kind is Kind.ALWAYS):
            self.due_ns = None
        elif rule.within_ns is None:
            return self._late(at_ns)
        elif self.due_ns is None:
            self.due_ns = at_ns + rule.within_ns
        return None

    def _late(self, due_ns: int) -> Found:
        rule = self.rule
        was = "was not true" if rule.kind is Kind.ALWAYS else "was true"
        longer = "" if rule.within_ns is None else f" for longer than {seconds(rule.within_ns)}"
        return due_ns, f"`{rule.condition.text}` {was}{longer}"


class _Response(_Watch):
    """`within`: each time that something begins, the condition is true in time."""

    def __init__(self, rule: Property) -> None:
        assert rule.within_ns is not None, "the file has it"
        super().__init__(rule)
        self._within_ns = rule.within_ns
        self._begin = _Edge(rule.after)

    def look(self, at_ns: int, values: Values) -> Found:
        if self.due_ns is not None and at_ns > self.due_ns:
            return self._late(self.due_ns)
        if self._begin.rises(values) and self.due_ns is None:
            self.due_ns = at_ns + self._within_ns
        if self.due_ns is not None and self.rule.condition.holds(values):
            self.due_ns = None
        return None

    def _late(self, due_ns: int) -> Found:
        rule, begin_ns = self.rule, due_ns - self._within_ns
        since = f"`{rule.after.text}` at {seconds(begin_ns)}" if rule.after is not None else "the begin"
        return due_ns, f"`{rule.condition.text}` was not true within {seconds(self._within_ns)} of {since}"


class _Stay(_Watch):
    """`stays`: from the begin on the condition is true until the end is."""

    def __init__(self, rule: Property) -> None:
        assert rule.until is not None, "the file has it"
        super().__init__(rule)
        self._until = rule.until
        self._begin, self._is_on = _Edge(rule.after), False

    def look(self, at_ns: int, values: Values) -> Found:
        rule = self.rule
        if self.due_ns is not None and at_ns > self.due_ns:
            return self._late(self.due_ns)
        if self._begin.rises(values):
            self._is_on = True
            self.due_ns = None if rule.within_ns is None else at_ns + rule.within_ns
        if self._is_on and self._until.holds(values):
            self._is_on, self.due_ns = False, None
        if self._is_on and not rule.condition.holds(values):
            return at_ns, f"`{rule.condition.text}` was not true until `{self._until.text}`"
        return None

    def _late(self, due_ns: int) -> Found:
        assert self.rule.within_ns is not None
        return due_ns, f"`{self._until.text}` was not true within {seconds(self.rule.within_ns)}"


class _Recovery(_Watch):
    """`eventually`: the machine comes back when all faults are over."""

    def __init__(self, rule: Property) -> None:
        assert rule.within_ns is not None, "the file has it"
        super().__init__(rule)
        self._within_ns = rule.within_ns
        self._is_met = False

    def look(self, at_ns: int, values: Values) -> Found:
        if self.due_ns is None:
            return None
        if at_ns > self.due_ns:
            return self.missed(at_ns)
        if self.rule.condition.holds(values):
            self._is_met, self.due_ns = True, None
        return None

    def heal(self, at_ns: int) -> None:
        if not self._is_met and self.due_ns is None:
            self.due_ns = at_ns + self._within_ns

    def hurt(self) -> None:
        self._is_met, self.due_ns = False, None

    def missed(self, at_ns: int) -> Found:
        if self.due_ns is None:
            return None
        what = f"`{self.rule.condition.text}` was not true within {seconds(self._within_ns)} of the end of all faults"
        return self.due_ns, what


def _watch_of(rule: Property) -> _Watch:
    match rule.kind:
        case Kind.ALWAYS | Kind.NEVER:
            return _Invariant(rule)
        case Kind.WITHIN:
            return _Response(rule)
        case Kind.STAYS:
            return _Stay(rule)
        case Kind.EVENTUALLY:
            return _Recovery(rule)
