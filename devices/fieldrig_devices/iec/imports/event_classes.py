"""The classes of events of a TwinCAT project, which its programs use as `TC_EVENTS.MyClass.MyEvent`.

Source: the public form of `.tsproj` and `.tmc`: a `DataType` with a GUID has the events as `EventId`, each with a name,
a number and a severity.  Their texts in languages are left out.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, read_xml, text_of

_NAME: Final = re.compile(r"[A-Za-z_]\w*")
_NUMBER: Final = re.compile(r"\d{1,10}")
_GUID: Final = re.compile(r"\{?([\dA-Fa-f]{8})-([\dA-Fa-f]{4})-([\dA-Fa-f]{4})-([\dA-Fa-f]{4})-([\dA-Fa-f]{12})\}?")
_SEVERITIES: Final = ("Verbose", "Info", "Warning", "Error", "Critical")


@dataclass(frozen=True, slots=True)
class Event:
    name: str
    number: int
    severity: str


@dataclass(frozen=True, slots=True)
class EventClass:
    name: str
    guid: str
    """Its value as a constant of Structured Text."""
    events: tuple[Event, ...]


def classes_of(text: str, report: Report) -> list[EventClass]:
    """Return the classes of events in a project; none if it has none, or is damaged."""
    root = read_xml(text, report)
    kinds = (
        [] if root is None else [one for group in elements(root, "DataTypes") for one in elements(group, "DataType")]
    )
    made = []
    for kind in kinds:
        named = element(kind, "Name")
        name, guid = text_of(named).strip(), _guid(attribute(named, "GUID"))
        events = tuple(event for one in elements(kind, "EventId") if (event := _event(one)) is not None)
        if events and guid and _NAME.fullmatch(name):
            made.append(EventClass(name, guid, events))
    return made


def _event(node: Element) -> Event | None:
    named = element(node, "Name")
    name, number, severity = text_of(named).strip(), attribute(named, "Id"), text_of(element(node, "Severity")).strip()
    if not _NAME.fullmatch(name) or not _NUMBER.fullmatch(number):
        return None
    return Event(name, int(number), severity if severity in _SEVERITIES else _SEVERITIES[0])


def _guid(text: str) -> str:
    match = _GUID.fullmatch(text)
    if match is None:
        return ""
    rest = match[4] + match[5]
    pairs = ", ".join(f"16#{rest[place : place + 2]}" for place in range(0, len(rest), 2))
    return f"(Data1 := 16#{match[1]}, Data2 := 16#{match[2]}, Data3 := 16#{match[3]}, Data4 := [{pairs}])"


def declarations(classes: Sequence[EventClass]) -> str:
    """Return the lists TC_EVENTS and TC_EVENT_CLASSES as TwinCAT makes them; an empty text for no classes.

    Of classes with the same name the first one counts.
    """
    known: dict[str, EventClass] = {}
    for one in classes:
        known.setdefault(one.name.casefold(), one)
    if not known:
        return ""
    lines = []
    for one in known.values():
        entries = "\n".join(f"    {event.name} : TcEventEntry := ({_entry(one, event)});" for event in one.events)
        lines.append(f"TYPE ST_{one.name} : STRUCT\n{entries}\nEND_STRUCT; END_TYPE")
    for name, component in (("TC_EVENTS", "{0} : ST_{0};"), ("TC_EVENT_CLASSES", "{0} : GUID := {1};")):
        parts = "\n".join(f"    {component.format(one.name, one.guid)}" for one in known.values())
        lines.append(f"TYPE ST_{name} : STRUCT\n{parts}\nEND_STRUCT; END_TYPE")
        lines.append(f"VAR_GLOBAL CONSTANT {name} : ST_{name}; END_VAR")
    return "\n".join(lines)


def _entry(of: EventClass, event: Event) -> str:
    return f"uuidEventClass := {of.guid}, nEventID := {event.number}, eSeverity := TcEventSeverity.{event.severity}"
