"""The writer of FB_JsonSaxWriter: a text that grows by one key or value after the other."""

from dataclasses import dataclass, field

from fieldrig_devices.iec.tcunit.json.nodes import PLACES, SCALAR, quoted, scalar_text


@dataclass(slots=True)
class _Level:
    """An object or an array that is open, and the number of keys and values in it."""

    is_array: bool
    count: int = 0


@dataclass(slots=True)
class Writer:
    """The text of one instance.  A call out of order makes a text that is not valid, and no error."""

    places: int = PLACES
    parts: list[str] = field(default_factory=list)
    _levels: list[_Level] = field(default_factory=list)

    @property
    def text(self) -> str:
        return "".join(self.parts)

    def reset(self) -> None:
        self.parts.clear()
        self._levels.clear()

    def value(self, value: SCALAR) -> None:
        self.raw(scalar_text(value, self.places))

    def key(self, name: str) -> None:
        self.raw(quoted(name))

    def raw(self, text: str) -> None:
        """Write a value that is text of JSON already."""
        self._separate()
        self.parts.append(text)

    def begin(self, *, is_array: bool) -> None:
        self.raw("[" if is_array else "{")
        self._levels.append(_Level(is_array))

    def end(self, *, is_array: bool) -> None:
        if self._levels:
            self._levels.pop()
        self.parts.append("]" if is_array else "}")

    def _separate(self) -> None:
        if not self._levels:
            return
        level = self._levels[-1]
        if level.count:
            self.parts.append(":" if not level.is_array and level.count % 2 else ",")
        level.count += 1
