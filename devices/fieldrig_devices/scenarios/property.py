"""The properties that have to hold in a scenario, over time."""

from enum import StrEnum
from typing import NamedTuple

from fieldrig_devices.scenarios.expression import Expression


class Kind(StrEnum):
    """The kinds of properties."""

    ALWAYS = "always"
    """The condition is true at every instant from `after` on."""
    NEVER = "never"
    """The condition is true at no instant from `after` on."""
    WITHIN = "within"
    """The condition becomes true within a time from each instant at which `after` becomes true."""
    STAYS = "stays"
    """The condition is true from each instant at which `after` becomes true until `until` is."""
    EVENTUALLY = "eventually"
    """The condition becomes true within a time after the last action, when no fault is left: the machine comes back."""


class Property(NamedTuple):
    name: str
    kind: Kind
    condition: Expression
    after: Expression | None = None
    """None: from the begin of the scenario."""
    until: Expression | None = None
    within_ns: int | None = None
    """The longest time; of `always` and `never` that for which they may be wrong."""
    line: int = 0
    """The line of its file; 0 without one."""

    @property
    def places(self) -> tuple[str, ...]:
        """The places that it reads, each once."""
        expressions = [one for one in (self.condition, self.after, self.until) if one is not None]
        return tuple(dict.fromkeys(place for one in expressions for place in one.places))


class Violation(NamedTuple):
    """The first instant at which a property does not hold."""

    property: str
    at_ns: int
    """The instant from the begin of the scenario, in nanoseconds."""
    what: str
    """The reason, as a sentence."""
    values: tuple[tuple[str, object], ...]
    """The places that the property reads, with their values then."""
