"""Makes the actions of a finding few, round, early and short, as long as the same property does not hold."""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.shrinking import fewest
from fieldrig_devices.scenarios.act import Act, Schedule

GRIDS_NS: Final = (1 * S, 500 * MS, 100 * MS, 50 * MS, 10 * MS, 1 * MS)
"""Times that are easy to read, the roundest first."""
SHORTEST_MS: Final = 1
DURATION: Final = "duration_ms"

Fails = Callable[[Schedule], bool]


def minimal(acts: Schedule, fails: Fails) -> Schedule:
    """Return actions that still fail; `acts` fail."""
    kept = tuple(fewest(acts, lambda some: fails(tuple(some))))
    for number in range(len(kept)):
        kept = _first(kept, number, _earlier(kept[number]), fails)
        kept = _first(kept, number, _rounder(kept[number]), fails)
        kept = _shorter(kept, number, fails)
    # What has been moved may do the work of another one now.
    return tuple(sorted(fewest(kept, lambda some: fails(tuple(some))), key=lambda act: act.at_ns))


def _first(acts: Schedule, number: int, others: list[Act], fails: Fails) -> Schedule:
    """Return the actions with the first of the other forms of one of them that still fails."""
    tried = (_with(acts, number, other) for other in others)
    return next((one for one in tried if fails(one)), acts)


def _with(acts: Schedule, number: int, act: Act) -> Schedule:
    return (*acts[:number], act, *acts[number + 1 :])


def _earlier(act: Act) -> list[Act]:
    return [act._replace(at_ns=act.at_ns * part // 8 // MS * MS) for part in range(8) if act.at_ns > 0]


def _rounder(act: Act) -> list[Act]:
    """Return the action at round instants near its own."""
    near = [(act.at_ns + grid_ns * offset) // grid_ns * grid_ns for grid_ns in GRIDS_NS for offset in (0, 1)]
    return [act._replace(at_ns=at_ns) for at_ns in dict.fromkeys(near) if at_ns != act.at_ns]


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
        return act._replace(value={**act.value, DURATION: str(half)}) if half >= SHORTEST_MS else None
    return None
