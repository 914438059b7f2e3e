"""Faults of buses and devices in one form: where, what, when, how long, how often.

A bus or device has a settings model for each of its faults, derived from `Timed` and with a literal `what`.  A rig file
lists faults under `faults:`; a running rig takes the same as plain values from a test, or as texts from `fieldrig
fault`.  Chance comes from a given `random.Random` and from a key of the affected message, so it does not depend on the
order in which a model looks at its messages.
"""

from collections.abc import Callable, Iterator, Mapping
from random import Random
from types import MappingProxyType, NoneType, UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Final,
    Generic,
    Literal,
    Protocol,
    TypeVar,
    Union,
    get_args,
    get_origin,
    runtime_checkable,
)

from pydantic import Field, ValidationError, field_validator

from fieldrig.clock import MS
from fieldrig.config.wording import explain
from fieldrig.config.yaml_source import key_text, read
from fieldrig.faults.condition import condition_of
from fieldrig.settings import Settings
from fieldrig.text.nearest import closest

LONGEST_MS: Final = 1_000_000_000  # eleven days
HOW_OFTEN: Final = ("nth", "count", "probability")
MOST_MESSAGES: Final = 1_000_000_000
_64: Final = (1 << 64) - 1


class Timed(Settings):
    """Start and duration of a fault."""

    counts_uses: ClassVar[bool] = False
    """True if each use counts, such as a message that it spoils; the fault of a device that is a state counts once."""

    names: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Keys that name something on the bus: the `what` of a claim, or `MEMBER`, by key."""

    start_ms: float = Field(
        default=0, ge=0, le=LONGEST_MS, description="after it was given; in a rig file, after the rig's start"
    )
    duration_ms: float | None = Field(default=None, gt=0, le=LONGEST_MS, description="left out: until it is cleared")
    when: str | None = Field(
        default=None, description="a condition on a point: start_ms counts from the instant at which it is met"
    )

    @field_validator("when")
    @classmethod
    def _check_when(cls, when: str | None) -> str | None:
        if when is not None:
            condition_of(when)
        return when


class Repeated(Timed):
    """A fault of single messages, which says how often it applies."""

    counts_uses: ClassVar[bool] = True

    nth: int = Field(
        default=1, ge=1, le=MOST_MESSAGES, description="the first message that it affects, of those that match"
    )
    count: int | None = Field(default=None, ge=1, description="number of messages; left out: any number")
    probability: float = Field(default=1.0, gt=0, le=1, description="probability for each message")

    @property
    def is_for_each(self) -> bool:
        """True if it applies to every message that matches."""
        return self.nth == 1 and self.count is None and self.probability >= 1


@runtime_checkable
class Counted(Protocol):
    """The settings of a fault that ends after it was applied `count` times; None is no limit."""

    @property
    def count(self) -> int | None: ...


@runtime_checkable
class Chancy(Protocol):
    """The settings of a fault that applies only with some probability, from 0 to 1."""

    @property
    def probability(self) -> float: ...


S = TypeVar("S", bound=Timed, covariant=True)


class Fault(Generic[S]):
    """One fault that was added, with its state."""

    __slots__ = (
        "_count",
        "_last_key",
        "_probability",
        "_salt",
        "_to_come",
        "applied",
        "number",
        "settings",
        "start_ns",
        "until_ns",
    )

    def __init__(self, number: int, settings: S, now_ns: int, salt: int) -> None:
        self.number, self.settings, self._salt = number, settings, salt
        self.begin(now_ns)
        self._count: int | None = settings.count if isinstance(settings, Counted) else None
        self._probability = settings.probability if isinstance(settings, Chancy) else 1.0
        self._to_come = settings.nth if isinstance(settings, Repeated) else 1
        self._last_key: int | None = None
        self.applied = 0

    def begin(self, now_ns: int) -> None:
        """Count the times of the fault from now on."""
        self.start_ns = now_ns + round(self.settings.start_ms * MS)
        duration_ms = self.settings.duration_ms
        self.until_ns: int | None = None if duration_ms is None else self.start_ns + round(duration_ms * MS)

    def is_over(self, now_ns: int) -> bool:
        is_used_up = self._count is not None and self.applied >= self._count
        return (self.until_ns is not None and now_ns >= self.until_ns) or is_used_up

    def is_on(self, now_ns: int) -> bool:
        return now_ns >= self.start_ns and not self.is_over(now_ns)

    def happens(self, key: int) -> bool:
        """Return whether the fault applies to the message that `key` stands for, given its number and probability.

        Call it for messages that match only; a message that is asked about twice in a row counts once.
        """
        if self._to_come > 1:
            if key != self._last_key:
                self._to_come -= 1
                self._last_key = key
            return False
        if key == self._last_key:
            return False
        return self._probability >= 1 or self.chance(key) < self._probability * (1 << 64)

    def chance(self, key: int) -> int:
        """Return 64 random bits that are always the same for one key (SplitMix64, Steele et al. 2014)."""
        mixed = self._salt + key * 0x9E37_79B9_7F4A_7C15 & _64
        mixed = (mixed ^ mixed >> 30) * 0xBF58_476D_1CE4_E5B9 & _64
        mixed = (mixed ^ mixed >> 27) * 0x94D0_49BB_1331_11EB & _64
        return mixed ^ mixed >> 31

    def about(self, now_ns: int) -> dict[str, Any]:
        """Return what was given, the state, how often it was applied, and for a limited time how much is left."""
        state = "over" if self.is_over(now_ns) else "on" if self.is_on(now_ns) else "waiting"
        given = self.settings.model_dump(exclude_unset=True)
        ordered = {key: given[key] for key in keys_of(type(self.settings)) if key in given}
        left = {} if state != "on" or self.until_ns is None else {"left_ms": -(-(self.until_ns - now_ns) // MS)}
        return {**ordered, "state": state, "applied": self.applied, **left}


F = TypeVar("F", bound=Fault[Any])


class Faults(Generic[F]):
    """The faults of one bus or device, in the order in which they were added."""

    def __init__(self, make: Callable[[int, Any, int, int], F], random: Random | None = None) -> None:
        """`make` is the class of the faults."""
        self._make = make
        self._random = random or Random(0)
        self._live: dict[int, F] = {}
        self._held: dict[int, F] = {}
        """The faults whose condition has not been met yet; they are in no iteration."""
        self._given = 0
        self.on_use: Callable[[F], None] | None = None
        """Called with each fault that a device has applied to a message."""

    @property
    def given(self) -> int:
        """The highest number so far."""
        return self._given

    def add(self, now_ns: int, settings: Timed, number: int | None = None) -> F:
        """Add a fault under the next number, or under `number` if the caller adds it in several places."""
        number = self._given + 1 if number is None else number
        self._given = max(self._given, number)
        fault = self._make(number, settings, now_ns, self._random.getrandbits(64))
        (self._live if settings.when is None else self._held)[fault.number] = fault
        return fault

    def release(self, now_ns: int, number: int) -> F | None:
        """Begin a fault whose condition is met now, and return it; None if it waits for none."""
        fault = self._held.pop(number, None)
        if fault is not None:
            fault.begin(now_ns)
            self._live[number] = fault
        return fault

    def is_held(self, number: int) -> bool:
        """Return whether a fault still waits for its condition."""
        return number in self._held

    def reserve(self, number: int) -> None:
        """Give numbers above this one from now on."""
        self._given = max(self._given, number)

    def adopt(self, faults: "Faults[F]") -> None:
        """Have the faults of `faults` instead of the present ones."""
        self._live.clear()
        self._live.update(faults._live)
        self._held = faults._held
        self._given = faults._given

    def clear(self, number: int) -> F:
        if number in self._held:
            return self._held.pop(number)
        try:
            return self._live.pop(number)
        except KeyError:
            there = ", ".join(map(str, sorted({**self._live, **self._held})))
            remedy = f"there are: {there}" if there else "there are none"
            raise ValueError(f"there is no fault {number}\n{remedy}") from None

    def __iter__(self) -> Iterator[F]:
        return iter(self._live.values())

    def of(self, *kinds: type[Any]) -> Iterator[F]:
        return (fault for fault in self._live.values() if isinstance(fault.settings, kinds))

    def use(self, fault: F) -> None:
        """Count a use of a fault."""
        fault.applied += 1
        if self.on_use is not None:
            self.on_use(fault)

    def is_any_left(self, now_ns: int) -> bool:
        return any(not fault.is_over(now_ns) for fault in self._live.values())

    def about(self, now_ns: int) -> dict[int, dict[str, Any]]:
        held = {number: {**fault.about(now_ns), "state": "waiting"} for number, fault in self._held.items()}
        found = {number: fault.about(now_ns) for number, fault in self._live.items()}
        return dict(sorted({**found, **held}.items())) if held else found


def keys_of(model: type[Timed]) -> list[str]:
    """Return the keys of a fault in the order of its form: what, where, how often, when and how long."""
    own = [key for key in model.model_fields if key not in HOW_OFTEN and key not in Timed.model_fields]
    return [*own, *(key for key in (*HOW_OFTEN, *Timed.model_fields) if key in model.model_fields)]


def models_of(union: Any) -> dict[str, type[Timed]]:
    """Return the settings models of an annotated union of faults, by their `what`."""
    return {get_args(model.model_fields["what"].annotation)[0]: model for model in get_args(get_args(union)[0])}


def fault_of(given: Mapping[str, Any], models: Mapping[str, type[Timed]]) -> Timed:
    """Return the settings of a fault that is given to a running bus or device, with values as people type them.

    A key whose model expects a text keeps its text, even if YAML would read a number.  ValueError if `given` is not a
    fault of `models`: its first line says what is wrong, further lines say what was expected.
    """
    what = given.get("what")
    model = models.get(what) if isinstance(what, str) else None
    if model is None:
        wrong = f"there is no fault {what!r}" if "what" in given else "what: this key is missing"
        raise ValueError(f"{wrong}\n{closest(what, list(models))}")
    values = {key: value if _is_text(model, key) else _value(key, value) for key, value in given.items()}
    try:
        return model.model_validate(values)
    except ValidationError as cause:
        mistakes = explain(cause, values, model)
        lines = [(f"{key_text(wrong.path)}: {wrong.what}".removeprefix(": "), wrong.remedy) for wrong in mistakes]
        raise ValueError("\n".join(line for both in lines for line in both if line)) from cause


def _is_text(model: type[Timed], key: str) -> bool:
    """True if a field of `model` takes texts only, apart from None."""
    field = model.model_fields.get(key)
    return field is not None and all(issubclass(kind, str | NoneType) for kind in _kinds_in(field.annotation))


def _kinds_in(annotation: Any) -> Iterator[type]:
    """Yield the types that an annotation of a field allows."""
    origin = get_origin(annotation)
    if origin is Literal:
        yield from map(type, get_args(annotation))
    elif origin is Annotated:
        yield from _kinds_in(get_args(annotation)[0])
    elif origin in (Union, UnionType):
        for kind in get_args(annotation):
            yield from _kinds_in(kind)
    else:
        yield origin or annotation


def _value(key: str, value: Any) -> Any:
    if not isinstance(value, str):
        return value
    source = read(value, "")
    if source.mistakes:
        raise ValueError(f"{key}: {value!r} is not a value as in a rig file\n{source.mistakes[0].what}")
    return source.data
