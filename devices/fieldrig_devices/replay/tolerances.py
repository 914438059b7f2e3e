"""Tolerances of a replay: differences of time and of values, and objects that are not compared."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import lru_cache
from typing import Final

from fieldrig.clock import MS
from fieldrig.errors import UsageError
from fieldrig.text.nearest import closest
from fieldrig.traces.parts import Part, PartDifference, differences

MOST_NAMES: Final = 2_000
"""Values whose names are looked at, to find what a word means."""
INDEX_DIGITS: Final = 4
"""Hex digits of an index; identifiers of CAN have three or eight."""
_HEX: Final = re.compile(r"(?:0x)?([0-9a-f]{3,8})h?(?::([0-9a-f]{2}))?")
TIME_NS: Final = 20 * MS
"""Default of the tolerance for times: what a device may be faster or slower than the one in the log."""


@dataclass(frozen=True)
class Tolerances:
    """The tolerances of one comparison."""

    time_ns: int = TIME_NS
    values: Mapping[str, float] = field(default_factory=dict)
    """The largest difference of a value by its object (`6064h`) or register, with the device before it if need be."""
    leave_out: Sequence[str] = ()
    """Patterns of objects and registers that are not compared."""
    _met: set[str] = field(default_factory=set, init=False, compare=False)
    """The words of both that have named something."""
    _seen: dict[tuple[str, str], None] = field(default_factory=dict, init=False, compare=False)
    _known: dict[str, None] = field(default_factory=dict, init=False, compare=False)
    """Names of objects and registers that were compared, for the nearest one."""

    def differences(self, node: str, expected: Sequence[Part], actual: Sequence[Part]) -> Iterator[PartDifference]:
        """Yield the parts that differ by more than they may."""
        for found in differences(expected, actual):
            if not self._is_left_out(node, found) and not self._is_within(node, found):
                yield found

    def is_left_out(self, node: str, key: str, name: str = "") -> bool:
        """Return whether an object or register is not compared."""
        names = _names(node, key, name)
        met = [word for word in self.leave_out if _is_named(word, names)]
        self._met.update(met)
        return bool(met)

    def look_at(self, node: str, parts: Sequence[Part]) -> None:
        """Note which words name one of these values, whether or not it differs."""
        words = [word for word in (*self.values, *self.leave_out) if word not in self._met]
        for part in parts if words and len(self._seen) < MOST_NAMES else ():
            if (node, part.key) not in self._seen:
                self._seen[node, part.key] = None
                names = _names(node, part.key, part.name)
                self._known.update(dict.fromkeys(sorted(names)))
                self._met.update(word for word in words if _is_named(word, names))

    def unmet(self) -> Iterator[str]:
        """Yield a sentence about each word that names nothing of what was compared."""
        for option, words in (("--value-tolerance", self.values), ("--leave-out", self.leave_out)):
            for word in words:
                if word not in self._met:
                    near = f"; {closest(word, list(self._known))}" if self._known else ""
                    yield f"{option} {word} names nothing that was compared{near}"

    def _is_left_out(self, node: str, found: PartDifference) -> bool:
        part = found.expected or found.actual
        return part is not None and self.is_left_out(node, part.key, part.name)

    def _is_within(self, node: str, found: PartDifference) -> bool:
        expected, actual = found.expected, found.actual
        if expected is None or actual is None:
            return False
        if not isinstance(expected.value, int | float) or not isinstance(actual.value, int | float):
            return False
        names = _names(node, expected.key, expected.name)
        met = [word for word in self.values if not names.isdisjoint(spellings(word))]
        self._met.update(met)
        allowed = [self.values[word] for word in met]
        return bool(allowed) and abs(expected.value - actual.value) <= max(allowed)


def _is_named(word: str, names: Collection[str]) -> bool:
    return any(fnmatchcase(text, spelling) for spelling in spellings(word) for text in names)


def _names(node: str, key: str, name: str) -> set[str]:
    """Return how a user may call an object: with and without its device, which is `io` of `node 5 (io)`, or by it."""
    texts = {text.lower() for text in (key, name) if text}
    texts |= {part for text in texts for part in text.split("/", 1)}  # `knife/S-0-0051` in a telegram of a ring
    within = node.partition("(")[2].rstrip(")")
    devices = {device.lower() for device in (node, within) if device}
    return texts | devices | {f"{device}/{text}" for device in devices for text in texts}


@lru_cache(maxsize=1_024)
def spellings(word: str) -> tuple[str, ...]:
    """Return a word of a user as it is, and as keys are written: `6064h` for `0x6064`, `1018h:01` for `1018:01`."""
    plain = word.strip().lower()
    device, slash, name = plain.rpartition("/")
    match = _HEX.fullmatch(name)
    if match is None:
        return (plain,)
    digits, subindex = match[1], match[2] or "00"
    key = digits if len(digits) != INDEX_DIGITS else f"{digits}h{'' if subindex == '00' else f':{subindex}'}"
    return plain, f"{device}{slash}{key}"


def value_tolerances(words: Sequence[str]) -> dict[str, float]:
    """Return the tolerances of words such as `6064h=3` and `io/6401h:01=5`.  UsageError for any other word."""
    found: dict[str, float] = {}
    for word in words:
        name, equals, number = word.rpartition("=")
        try:
            limit = float(number)
        except ValueError:
            limit = -1.0
        if not equals or not name or not limit >= 0:
            raise UsageError(f"{word!r} is not a tolerance", "expected an object or register and a number, as 6064h=3")
        found[name.strip()] = limit
    return found
