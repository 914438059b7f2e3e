"""The set-up of a scope: its signals, its window and its trigger.  A page sends it, and a file keeps it."""

from collections.abc import Sequence
from math import isfinite
from typing import Any, Final, Literal, NamedTuple, cast, get_args

from fieldrig.clock import MS, US, S
from fieldrig.outside.untrusted import MalformedError, items, shown, typed
from fieldrig_page.scope.triggers import LONGEST_TEXT, ON_SIGNALS, Trigger, read_trigger

Mode = Literal["run", "auto", "normal", "single"]
Rhythm = Literal["cycle", "change"] | int

MODES: Final[tuple[str, ...]] = get_args(Mode)
MOST_DRAWN: Final = 32
MOST_RECORDED: Final = 256
WINDOW_NS: Final = (10 * US, 3600 * S)
"""Shortest and longest window."""
PERIOD_NS: Final = (100 * US, 3600 * S)
"""Shortest and longest period of a sampler."""


class Setup(NamedTuple):
    """A set-up, checked."""

    signals: tuple[str, ...] = ()
    """The signals that are drawn, from top to bottom."""
    recorded: tuple[str, ...] = ()
    """Further signals that are recorded, and go into captures and exports."""
    rhythm: Rhythm = "cycle"
    """When a value is taken: at the end of each cycle of its device, and of wires at each change; at each change of all
    signals; or with a period in nanoseconds."""
    window_ns: int = 10 * S
    before: float = 0.5
    """Part of the window before the trigger, 0 to 1."""
    mode: Mode = "run"
    trigger: Trigger | None = None
    xy: tuple[str, str] | None = None
    """The signals across and up of the XY view."""

    @property
    def all_signals(self) -> tuple[str, ...]:
        """Each signal once, those that are drawn first; also that of the trigger."""
        of_trigger = (self.trigger.signal,) if self.trigger is not None and self.trigger.kind in ON_SIGNALS else ()
        return tuple(dict.fromkeys((*self.signals, *self.recorded, *of_trigger, *(self.xy or ()))))

    @property
    def before_ns(self) -> int:
        return round(self.window_ns * self.before)

    def as_data(self) -> dict[str, Any]:
        data = {key: list(value) if isinstance(value, tuple) else value for key, value in self._asdict().items()}
        return data | {"trigger": None if self.trigger is None else self.trigger.as_data()}


def read_setup(data: Any) -> Setup:
    """Return the set-up that `data` from outside describes; keys that are missing have their defaults.

    MalformedError, with the key and what was expected, for anything else.
    """
    if not isinstance(data, dict):
        raise MalformedError(f"expected a set-up, found {shown(data)}")
    unknown = data.keys() - set(Setup._fields)
    if unknown:
        raise MalformedError(f"{shown(min(map(str, unknown)))}: expected one of {', '.join(Setup._fields)}")
    usual = Setup()
    setup = Setup(
        signals=_names(data, "signals", MOST_DRAWN),
        recorded=_names(data, "recorded", MOST_RECORDED),
        rhythm=_rhythm(data.get("rhythm", usual.rhythm)),
        window_ns=_within(data.get("window_ns", usual.window_ns), WINDOW_NS, "window_ns"),
        before=_part(data.get("before", usual.before)),
        mode=_mode(data.get("mode", usual.mode)),
        trigger=None if data.get("trigger") is None else read_trigger(data["trigger"]),
        xy=_pair(data.get("xy")),
    )
    if setup.mode in ("normal", "single") and setup.trigger is None:
        raise MalformedError(f"trigger: the mode {setup.mode} waits for one")
    return setup


def _names(data: dict[str, Any], key: str, most: int) -> tuple[str, ...]:
    names = items(data.get(key, []), str, most, key)
    for name in names:
        if not 0 < len(name) <= LONGEST_TEXT:
            raise MalformedError(f"{key}: expected PART/KEY, found {shown(name)}")
    return tuple(dict.fromkeys(names))


def _rhythm(value: Any) -> Rhythm:
    match value:
        case "cycle":
            return "cycle"
        case "change":
            return "change"
    if isinstance(value, int | float) and not isinstance(value, bool):
        return _within(value, PERIOD_NS, "rhythm")
    raise MalformedError(f"rhythm: expected cycle, change or a period in ns, found {shown(value)}")


def _within(value: Any, limits: tuple[int, int], key: str) -> int:
    number = typed(value, float, key)  # JavaScript has no integers: a whole number may arrive as a float
    if not isfinite(number) or not limits[0] <= number <= limits[1]:
        raise MalformedError(f"{key}: expected {limits[0] / MS:g} to {limits[1] / MS:g} ms in ns, found {shown(value)}")
    return round(number)


def _part(value: Any) -> float:
    part = typed(value, float, "before")
    if not 0 <= part <= 1:
        raise MalformedError(f"before: expected 0 to 1, found {shown(value)}")
    return part


def _mode(value: Any) -> Mode:
    for mode in get_args(Mode):
        if value == mode:
            return cast(Mode, mode)
    raise MalformedError(f"mode: expected one of {', '.join(MODES)}, found {shown(value)}")


def _pair(value: Any) -> tuple[str, str] | None:
    if value is None:
        return None
    names: Sequence[str] = items(value, str, 2, "xy")
    if len(names) != 2:
        raise MalformedError("xy: expected two signals")
    return names[0], names[1]
