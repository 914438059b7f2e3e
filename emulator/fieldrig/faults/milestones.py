"""The conditions at which faults of a rig file begin: that each can be met, as far as the rig shows before it runs."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from fieldrig.config.build import build_alone
from fieldrig.config.entries import DeviceEntry
from fieldrig.config.kinds import constructor_parameters
from fieldrig.config.yaml_source import KeyPath, Source, key_text
from fieldrig.device import FAULTS_KEY, Point
from fieldrig.errors import ConfigError, Mistake
from fieldrig.faults.condition import Condition, condition_of, never
from fieldrig.text.nearest import closest


def wrong_conditions(source: Source, devices: Iterable[DeviceEntry]) -> Iterator[Mistake]:
    """Yield the conditions of faults with a device, point or state that does not exist.

    `devices` are those without mistakes; the points of others are not known.
    """
    entries = {device.name: device for device in devices}
    for path, text in _conditions(source.data):
        try:
            condition = condition_of(text)
        except ValueError:
            continue  # a mistake of the fault itself
        for wrong in _wrong(condition, path, source.data, entries):
            what, _, remedy = wrong.partition("\n")
            yield Mistake(*source.mark(path), key_text(path), what, remedy)


def _conditions(data: Any) -> Iterator[tuple[KeyPath, str]]:
    for section in ("buses", "devices"):
        for name, entry in _mapping(_mapping(data).get(section)).items():
            faults = _mapping(entry).get(FAULTS_KEY)
            for number, fault in enumerate(faults if isinstance(faults, list) else ()):
                when = _mapping(fault).get("when")
                if isinstance(when, str):
                    yield (section, name, FAULTS_KEY, number, "when"), when


def _wrong(condition: Condition, path: KeyPath, data: Any, entries: Mapping[str, DeviceEntry]) -> Iterator[str]:
    """Yield what is wrong with a condition, and in the next line what would be right."""
    names, buses = ([str(name) for name in _mapping(_mapping(data).get(part))] for part in ("devices", "buses"))
    if condition.device in buses:
        return  # its signals are known once a device drives them
    if condition.device not in names:
        yield f"there is no device {condition.device!r}\n{closest(condition.device, names)}"
    elif condition.device in entries:
        yield from _wrong_point(condition, entries[condition.device])


def _wrong_point(condition: Condition, entry: DeviceEntry) -> Iterator[str]:
    try:
        points = build_alone(entry).points()
    except ConfigError:
        return  # a mistake of the device
    if condition.key in points:
        yield from _wrong_state(condition, points[condition.key])
    elif "background" not in constructor_parameters(entry.cls):  # it has more points once its program is compiled
        yield f"{entry.name} has no value {condition.key!r}\n{closest(condition.key, list(points))}"


def _wrong_state(condition: Condition, point: Point) -> Iterator[str]:
    wrong = never(condition, point.read(), point.states)
    if wrong is not None:
        yield wrong


def _mapping(data: Any) -> Mapping[Any, Any]:
    return data if isinstance(data, dict) else {}
