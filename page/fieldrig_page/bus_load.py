"""How busy a bus is, in a few words for its name in the picture, from the counters of `fieldrig status`."""

from collections.abc import Mapping
from math import isfinite
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS, S

COUNTERS: Final = {
    "requests": "requests/s",
    "messages": "messages/s",
    "frames": "frames/s",
    "characters": "characters/s",
    "bytes": "bytes/s",
    "bytes_in": "bytes/s in",
}
"""The counters whose rate says how busy a bus is; the first one that a bus has is taken."""


LATE: Final = "late."
"""Begins the counters of late cycles of single stations."""


class Reading(NamedTuple):
    """The counters of a bus at an instant of the rig."""

    now_ns: int
    figures: Mapping[str, float]


def numbers_of(figures: Any) -> dict[str, float]:
    """Return the finite numbers among the counters of a bus; a kind of a user may have others."""
    found = figures.items() if isinstance(figures, Mapping) else ()
    return {name: value for name, value in found if isinstance(value, int | float) and isfinite(value)}


def load_words(before: Reading | None, now: Reading) -> str:
    """Return how busy a bus is, such as `12 %`, `4 ms, 98 % kept` or `3 requests/s`; "" if it does not count.

    Rates are of the time between the two readings.
    """
    figures = now.figures
    if "load_percent" in figures:
        return f"{figures['load_percent']:g} %"
    elapsed_ns = 0 if before is None else now.now_ns - before.now_ns
    if "cycles" in figures:
        return "" if before is None else _of_cycles(before.figures, figures, elapsed_ns)
    counter = next((name for name in COUNTERS if name in figures), None)
    if counter is not None and before is not None and elapsed_ns > 0:
        rate = max(figures[counter] - before.figures.get(counter, 0.0), 0.0) * S / elapsed_ns
        return f"{_rounded(rate)} {COUNTERS[counter]}"
    if "wires" in figures:
        return f"{figures['wires']:g} wires"
    return ""


def kept_percent(before: Reading | None, now: Reading) -> dict[str, int]:
    """Return the share of the cycles since the reading before that each station of a ring kept, in percent.

    Only a ring that counts them has any: in virtual time nothing is late.
    """
    if before is None or "cycles" not in now.figures:
        return {}
    cycles = now.figures["cycles"] - before.figures.get("cycles", 0.0)
    late = {name.removeprefix(LATE): value for name, value in now.figures.items() if name.startswith(LATE)}
    if cycles <= 0:
        return {}
    return {
        name: round(100 * max(1 - (value - before.figures.get(f"{LATE}{name}", 0.0)) / cycles, 0))
        for name, value in late.items()
    }


def _of_cycles(before: Mapping[str, float], now: Mapping[str, float], elapsed_ns: int) -> str:
    cycles = now["cycles"] - before.get("cycles", 0.0)
    if cycles <= 0 or elapsed_ns <= 0:
        return "no cycles"
    words = [f"{_rounded(elapsed_ns / cycles / MS)} ms"]
    if "late_cycles" in now:
        late = now["late_cycles"] - before.get("late_cycles", 0.0)
        words.append(f"{100 * max(1 - late / cycles, 0):.0f} % kept")
    return ", ".join(words)


def _rounded(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.1f}".removesuffix(".0")
