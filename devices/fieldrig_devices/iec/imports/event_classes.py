"""The classes of events of a TwinCAT project, which its programs use as `TC_EVENTS.MyClass.MyEvent`.

Source: the public form of `.tsproj` and `.tmc`: a `DataType` with a GUID has the events as `EventId`, each with a name,
a number, a severity, and a text in each of some languages, as classes have names.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.imports.report import Report
from fieldrig_devices.iec.imports.xml import Element, attribute, element, elements, read_xml, text_of

_NAME: Final = re.compile(r"[A-Za-z_]\w*")
_NUMBER: Final = re.compile(r"\d{1,10}")
_GUID: Final = re.compile(r"\{?([\dA-Fa-f]{8})-([\dA-Fa-f]{4})-([\dA-Fa-f]{4})-([\dA-Fa-f]{4})-([\dA-Fa-f]{12})\}?")
_ENGLISH: Final = 1033
"""The number of the language of a text that names none."""
LONGEST_TEXT: Final = 255
TEXTS: Final = "FieldrigProjectTexts"
"""The variable with the texts."""
TAKES_TEXTS: Final = "FieldrigTakesTexts"
"""The variable whose start value hands them to the library."""
Texts = tuple[tuple[int, str], ...]
"""The texts with the numbers of their languages."""
_SEVERITIES: Final = ("Verbose", "Info", "Warning", "Error", "Critical")


@dataclass(frozen=True, slots=True)
class Event:
    name: str
    number: int
    severity: str
    texts: Texts = ()


@dataclass(frozen=True, slots=True)
class EventClass:
    name: str
    guid: str
    """Its value as a constant of Structured Text."""
    events: tuple[Event, ...]
    titles: Texts = ()


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
            made.append(EventClass(name, guid, events, _texts(kind)))
    return made


def _event(node: Element) -> Event | None:
    named = element(node, "Name")
    name, number, severity = text_of(named).strip(), attribute(named, "Id"), text_of(element(node, "Severity")).strip()
    if not _NAME.fullmatch(name) or not _NUMBER.fullmatch(number):
        return None
    severity = severity if severity in _SEVERITIES else _SEVERITIES[0]
    return Event(name, int(number), severity, _texts(node))


def _texts(node: Element) -> Texts:
    made = dict[int, str]()
    for one in elements(node, "DisplayName"):
        language = attribute(one, "LcId")
        if text := text_of(one).strip():
            made.setdefault(int(language) if _NUMBER.fullmatch(language) else _ENGLISH, text)
    return tuple(made.items())


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
    return "\n".join([*lines, *_with_texts(known.values())])


def _with_texts(classes: Iterable[EventClass]) -> list[str]:
    """Return the declaration of the texts, if there are any."""
    parts = [
        f"(uuid := {one.guid}, {which}, language := {language}, text := '{_quoted(text)}')"
        for one in classes
        for which, texts in (
            ("isClass := TRUE", one.titles),
            *((f"id := {event.number}", event.texts) for event in one.events),
        )
        for language, text in texts
    ]
    if not parts:
        return []
    return [
        f"VAR_GLOBAL {TEXTS} : ARRAY[1..{len(parts)}] OF FIELDRIG_EVENT_TEXT := [{', '.join(parts)}]; END_VAR",
        f"VAR_GLOBAL {TAKES_TEXTS} : BOOL := FIELDRIG_TakeEventTexts(ADR({TEXTS}), {len(parts)}); END_VAR",
    ]


def _quoted(text: str) -> str:
    """Return what is between the quotes of a STRING; what it cannot have is a question mark."""
    known = text[:LONGEST_TEXT].encode("latin-1", "replace")
    return "".join(chr(sign) if 32 <= sign < 127 and sign not in b"$'" else f"${sign:02X}" for sign in known)


def _entry(of: EventClass, event: Event) -> str:
    return f"uuidEventClass := {of.guid}, nEventID := {event.number}, eSeverity := TcEventSeverity.{event.severity}"
