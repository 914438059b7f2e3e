"""One property on its way, for each kind: when it waits, until when, and what breaks it."""

from collections.abc import Mapping

from fieldrig.device import Value
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.expression import Expression
from fieldrig_devices.scenarios.property import Kind, Property

Values = Mapping[str, Value]
Found = tuple[int, str] | None
"""The instant of a violation with its reason, or None."""


class Watch:
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


class _Invariant(Watch):
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


class _Response(Watch):
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


class _Stay(Watch):
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


class Recovery(Watch):
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

    @property
    def is_judged(self) -> bool:
        """True once all faults were over, so that the machine could come back."""
        return self._is_met or self.due_ns is not None

    def missed(self, at_ns: int) -> Found:
        if self.due_ns is None:
            return None
        what = f"`{self.rule.condition.text}` was not true within {seconds(self._within_ns)} of the end of all faults"
        return self.due_ns, what


def watch_of(rule: Property) -> Watch:
    match rule.kind:
        case Kind.ALWAYS | Kind.NEVER:
            return _Invariant(rule)
        case Kind.WITHIN:
            return _Response(rule)
        case Kind.STAYS:
            return _Stay(rule)
        case Kind.EVENTUALLY:
            return Recovery(rule)
