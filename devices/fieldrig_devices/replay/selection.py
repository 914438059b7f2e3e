"""The messages of a log that a user wants to be played: the words of `fieldrig replay --play`."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple, Self

from fieldrig.config.rig_file import RigConfig
from fieldrig.errors import UsageError
from fieldrig.text.nearest import closest
from fieldrig.traces.names import members_of
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_devices.canopen.names import NODES

MASTER: Final = "master"
WAYS: Final = "expected master, node=5, id=185, unit=3, client=10.0.0.7, sender=plc, or a device of the rig"


class Asked(NamedTuple):
    """A word that names messages of the log, and a pattern of the names that `Sides` gives them."""

    word: str
    pattern: str


@dataclass(frozen=True)
class Selection:
    """The messages that a user wants to be played."""

    is_master: bool = True
    nodes: frozenset[int] = frozenset()
    identifiers: frozenset[int] = frozenset()
    units: frozenset[int] = frozenset()
    senders: tuple[str, ...] = ()
    """Patterns of senders, of clients of Modbus as well."""
    devices: frozenset[str] = frozenset()
    """Devices of the rig that the log takes the place of."""
    asked: tuple["Asked", ...] = ()
    """The words that name messages of the log."""

    @classmethod
    def of(cls, words: Sequence[str], config: RigConfig) -> Self:
        """Return the selection that these words describe.  UsageError for a word that is not understood."""
        found = cls(is_master=not words or MASTER in words)
        for word in words:
            if word != MASTER:
                found = found._with(word, config)
        return found._with_devices(config)

    def _with(self, word: str, config: RigConfig) -> Self:
        key, equals, value = word.partition("=")
        if not equals:
            if word not in config.devices:
                raise UsageError(f"--play {word}: the rig has no such device", closest(word, [*config.devices, MASTER]))
            return replace(self, devices=self.devices | {word})
        try:
            match key.strip():
                case "node":
                    node = _within(_whole(value), NODES)
                    return self._naming(word, f"node={node}", nodes=self.nodes | {node})
                case "id":
                    identifier = _hexadecimal(value)
                    return self._naming(word, f"id={identifier:X}", identifiers=self.identifiers | {identifier})
                case "unit":
                    unit = _within(_whole(value), range(256))
                    return self._naming(word, f"unit={unit}", units=self.units | {unit})
                case "client" | "sender":
                    return self._naming(word, f"sender={value.strip()}", senders=(*self.senders, value.strip()))
        except ValueError as wrong:
            raise UsageError(f"--play {word}: {wrong}", WAYS) from wrong
        raise UsageError(f"--play {word}: there is no {key!r}", WAYS)

    def _naming(self, word: str, pattern: str, **parts: Any) -> Self:
        return replace(self, asked=(*self.asked, Asked(word, pattern)), **parts)

    def _with_devices(self, config: RigConfig) -> Self:
        """Return the selection with the devices whose nodes and units are played, and the other way round."""
        nodes, units, devices = set(self.nodes), set(self.units), set(self.devices)
        for bus in config.buses:
            for member in members_of(config, bus):
                ids = {claim.value for claim in member.claims("node-ID") if isinstance(claim.value, int)}
                served = {claim.value for claim in member.claims("unit") if isinstance(claim.value, int)}
                if member.entry.name in self.devices:
                    nodes |= ids
                    units |= served
                elif ids & self.nodes or served & self.units:
                    devices.add(member.entry.name)
        return replace(self, nodes=frozenset(nodes), units=frozenset(units), devices=frozenset(devices))


def _whole(text: str) -> int:
    try:
        return int(text, 0)
    except ValueError:
        raise ValueError(f"expected a whole number, got {text!r:.40}") from None


def _hexadecimal(text: str) -> int:
    try:
        return _within(int(text.removesuffix("h"), 16), range(EXTENDED_MASK + 1))
    except ValueError:
        raise ValueError(f"expected an identifier in hexadecimal digits, got {text!r:.40}") from None


def _within(number: int, numbers: range) -> int:
    if number not in numbers:
        raise ValueError(f"expected {numbers[0]} to {numbers[-1]}, got {number}")
    return number


def without(config: RigConfig, devices: Collection[str]) -> RigConfig:
    """Return the rig without these devices, whose place the log takes."""
    if not devices:
        return config
    return replace(config, devices={name: entry for name, entry in config.devices.items() if name not in devices})
