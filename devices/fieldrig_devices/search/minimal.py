"""Makes the actions of a finding few, early, round and short, and their values plain.

It is the project's own shrinking over schedules.  Hypothesis shrinks what it has drawn itself, in an order that knows
nothing of time: for three inputs of a program it took 94 s where `fieldrig.shrinking` took 1.5 s.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import takewhile
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.shrinking import fewest, least
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.search.choices import Choice

GRIDS_NS: Final = (1 * S, 500 * MS, 100 * MS, 50 * MS, 10 * MS, 1 * MS)
"""Times that are easy to read, the roundest first."""
MOST_LATER_NS: Final = 100 * MS
"""The time by which an action may become later so that its instant is round."""
SHORTEST_MS: Final = 1
EIGHTHS: Final = 8
DURATION: Final = "duration_ms"

Fails = Callable[[Schedule], bool]


def fewest_acts(acts: Schedule, fails: Fails) -> Schedule:
    """Return the actions that are needed to fail; `acts` fail."""
    return tuple(fewest(acts, lambda some: fails(tuple(some))))


def minimal(acts: Schedule, fails: Fails, choices: Sequence[Choice] = ()) -> Schedule:
    """Return actions that still fail; `acts` fail.  Values stay among those of the choices."""
    kept = fewest_acts(acts, fails)
    for number in range(len(kept)):
        kept = _earlier(kept, number, fails)
        kept = _first(kept, number, _rounder(kept[number]), fails)
        kept = _plainer(kept, number, fails, choices)
        kept = _shorter(kept, number, fails)
    # What has been moved may do the work of another one now.
    return tuple(sorted(fewest_acts(kept, fails), key=lambda act: act.at_ns))


def _first(acts: Schedule, number: int, others: Iterator[Act], fails: Fails) -> Schedule:
    """Return the actions with the first of the other forms of one of them that still fails."""
    tried = (_with(acts, number, other) for other in others if other != acts[number])
    return next((one for one in tried if fails(one)), acts)


def _with(acts: Schedule, number: int, act: Act) -> Schedule:
    return (*acts[:number], act, *acts[number + 1 :])


def _earlier(acts: Schedule, number: int, fails: Fails) -> Schedule:
    """Return the actions with one of them at the begin, or else at the earliest eighth of its time that is found."""
    act = acts[number]

    def moved(part: int) -> Schedule:
        return _with(acts, number, act._replace(at_ns=act.at_ns * part // EIGHTHS // MS * MS))

    if act.at_ns == 0 or fails(moved(0)):
        return acts if act.at_ns == 0 else moved(0)
    part = least(EIGHTHS, 1, lambda one: fails(moved(one)))
    return acts if part == EIGHTHS else moved(part)


def _rounder(act: Act) -> Iterator[Act]:
    """Yield the action at instants near its own that are rounder, the roundest first."""
    near = [(act.at_ns + grid_ns * offset) // grid_ns * grid_ns for grid_ns in GRIDS_NS for offset in (0, 1)]
    rounder = takewhile(lambda at_ns: at_ns != act.at_ns, dict.fromkeys(near))
    return (act._replace(at_ns=at_ns) for at_ns in rounder if at_ns <= act.at_ns + MOST_LATER_NS)


def _plainer(acts: Schedule, number: int, fails: Fails, choices: Sequence[Choice]) -> Schedule:
    """Return the actions with the plainest value of one of them that its choice has."""
    act = acts[number]
    choice = next((one for one in choices if one.has(act)), None)
    if choice is None:
        return acts
    if choice.span is None:
        before = choice.values[: choice.values.index(act.value)] if act.value in choice.values else ()
        return _first(acts, number, (act._replace(value=value) for value in before), fails)
    low = choice.span.low
    acts = _first(acts, number, (act._replace(value=value) for value in _near(act.value, low)), fails)
    value = acts[number].value
    if not (type(value) is int and isinstance(low, int)):
        return acts
    smallest = least(value, low, lambda one: fails(_with(acts, number, act._replace(value=one))))
    return _with(acts, number, act._replace(value=smallest))


def _near(value: object, low: int | float) -> list[int | float]:
    """Return round numbers from the lowest value to the present one."""
    if not isinstance(value, int | float):
        return []
    rounded = (round(value, digits) for digits in range(4)) if isinstance(value, float) else ()
    return [low, *(one for one in rounded if low <= one <= value)]


def _shorter(acts: Schedule, number: int, fails: Fails) -> Schedule:
    """Halve the duration of a key or a fault as often as possible."""
    while (shorter := _halved(acts[number])) is not None and fails(found := _with(acts, number, shorter)):
        acts = found
    return acts


def _halved(act: Act) -> Act | None:
    if act.verb == "press" and act.hold_ns >= 2 * SHORTEST_MS * MS:
        return act._replace(hold_ns=act.hold_ns // 2 // MS * MS)
    if isinstance(act.value, Mapping) and DURATION in act.value:
        half = int(float(act.value[DURATION])) // 2
        given = str(half) if isinstance(act.value[DURATION], str) else half
        return act._replace(value={**act.value, DURATION: given}) if half >= SHORTEST_MS else None
    return None
