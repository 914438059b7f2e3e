"""The messages of CANopen beside PDOs: NMT, SYNC, TIME, LSS, EMCY, heartbeat and SDO.

Source: CiA 301 version 4.2, 7.2.4 to 7.2.8 (protocols) and 7.3.5 (predefined connection set); CiA 305 (LSS).  What a
frame of SDO has depends on its command specifier, which is the selector of its signals.  Segments of a block have a
number in its place, so they look like other services; no file of this form can tell them apart.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import Final

from fieldrig_devices.canopen.abort import NAMES
from fieldrig_devices.canopen.bit_names import ERROR_REGISTER
from fieldrig_devices.canopen.cob_id import EXTENDED, is_valid
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.lss_words import SERVICES
from fieldrig_devices.canopen.names import (
    EMCY,
    ERROR_CONTROL,
    LSS_MASTER,
    LSS_SLAVE,
    NMT,
    NMT_COMMANDS,
    NMT_STATES,
    SDO_REQUEST,
    SDO_RESPONSE,
    SYNC,
    TIME,
)
from fieldrig_devices.canopen.sdo_names import ANSWERS, REQUESTS
from fieldrig_devices.export.network import NO_CHOICES, Message, Signal, with_unique_names
from fieldrig_devices.export.objects import error_names

ABORTS: Final = {code: name.lower().replace("_", " ") for code, name in NAMES.items()}
SEGMENT: Final = (Signal("data", 8, 56),)
OBJECT: Final = (Signal("index", 8, 16), Signal("subindex", 24, 8))
VALUE: Final = (*OBJECT, Signal("value", 32, 32))
ABORT: Final = (*OBJECT, Signal("code", 32, 32, choices=ABORTS))
REST: Final = (Signal("data", 8, 56),)
OF_REQUESTS: Final = {0: SEGMENT, 1: VALUE, 2: OBJECT, 3: REST, 4: ABORT, 5: OBJECT, 6: VALUE, 7: REST}
OF_ANSWERS: Final = {0: SEGMENT, 1: REST, 2: VALUE, 3: OBJECT, 4: ABORT, 5: OBJECT, 6: VALUE, 7: REST}
"""The signals behind each command specifier."""
NAMED_IN: Final = frozenset(("write index", "read index", "value index", "written index"))
"""Signals that name the object: in all of them the names would be most of the file."""


def of_network(names: Mapping[int, str], master: str, sync_by: str, *, counts_sync: bool) -> Iterator[Message]:
    """Yield the messages that concern all nodes; `names` are those of the nodes by node-ID.

    A SYNC has a counter if a node is configured for it (1019h), and is empty otherwise.
    """
    everybody = tuple(names.values())
    command = Signal("command", 0, 8, choices=NMT_COMMANDS)
    yield Message(
        NMT, "NMT", 2, (command, Signal("node", 8, 8, choices={0: "all nodes", **names})), master, everybody,
        "NMT: start, stop and reset of nodes",
    )  # fmt: skip
    counter = (Signal("counter", 0, 8),) if counts_sync else ()
    yield Message(SYNC, "SYNC", len(counter), counter, sync_by, everybody)
    clock = Signal("time_of_day", 0, 28, unit="ms", about="after midnight")
    yield Message(TIME, "TIME", 6, (clock, Signal("day", 32, 16, unit="d", about="since 1 January 1984")), master)
    for identifier, name, sender in ((LSS_MASTER, "LSS_request", master), (LSS_SLAVE, "LSS_answer", "")):
        yield Message(identifier, name, 8, (Signal("service", 0, 8, choices=SERVICES), *REST), sender)


def of_node(node: str, node_id: int, dictionary: Dictionary | None, master: str) -> Iterator[Message]:
    """Yield EMCY, heartbeat and SDO of a node."""
    period_ms = 0 if dictionary is None else dictionary.number(0x1017, 0)
    state = Signal("state", 0, 7, choices=NMT_STATES)
    yield Message(
        ERROR_CONTROL + node_id, f"{node}_heartbeat", 1, (state, Signal("toggle", 7, 1, about="of node guarding")),
        node, (master,), f"state of {node}; boot-up at its start", period_ms=period_ms or None,
    )  # fmt: skip
    yield _at(_emcy(node, EMCY + node_id, master, error_names(dictionary)), dictionary, 0x1014, 0)
    objects = _objects(dictionary)
    request, answer = _sdo(REQUESTS, OF_REQUESTS, objects), _sdo(ANSWERS, OF_ANSWERS, objects)
    asks = Message(SDO_REQUEST + node_id, f"{node}_SDO_request", 8, request, master, (node,))
    yield _at(asks, dictionary, 0x1200, 1)
    answers = Message(SDO_RESPONSE + node_id, f"{node}_SDO_answer", 8, answer, node, (master,))
    yield _at(answers, dictionary, 0x1200, 2)


def _emcy(node: str, identifier: int, master: str, names: Mapping[int, str]) -> Message:
    bits = (Signal(name, 16 + bit, 1, about="of the error register") for bit, name in ERROR_REGISTER.items())
    signals = (Signal("error_code", 0, 16, choices=names), *bits, Signal("manufacturer_field", 24, 40))
    return Message(
        identifier, f"{node}_EMCY", 8, tuple(with_unique_names(signals)), node, (master,), f"errors of {node}"
    )


def _sdo(
    services: Mapping[int, str], content: Mapping[int, tuple[Signal, ...]], objects: Mapping[int, str]
) -> tuple[Signal, ...]:
    selector = Signal("service", 5, 3, choices={**services, 7: "SDO reserved"}, is_selector=True)
    flags = Signal("flags", 0, 5, about="toggle bit, size and end, by service")
    parts = [selector, flags]
    for specifier, signals in content.items():
        word = services.get(specifier, "SDO reserved").removeprefix("SDO ")
        parts += [_chosen(signal, word, specifier, objects) for signal in signals]
    return tuple(with_unique_names(parts))


def _chosen(signal: Signal, word: str, specifier: int, objects: Mapping[int, str]) -> Signal:
    name = f"{word} {signal.name}"
    choices = objects if name in NAMED_IN else signal.choices
    return Signal(name, signal.start, signal.length, choices=choices, selected_by=specifier)


def _objects(dictionary: Dictionary | None) -> Mapping[int, str]:
    """Return the names of the objects by index, with the index, which a tool shows no more beside a name."""
    if dictionary is None:
        return NO_CHOICES
    names: dict[int, list[str]] = {}
    for variable in dictionary:
        names.setdefault(variable.index, []).append(variable.name)
    return {index: f"{index:04X}h {_common(of)}".rstrip() for index, of in names.items()}


def _common(names: Sequence[str]) -> str:
    """Return the words with which the names of all sub-indices begin; that of sub-index 0 counts if it is alone."""
    columns = zip(*(name.split() for name in (names[1:] or names)), strict=False)
    return " ".join(column[0] for column in takewhile(lambda column: len({*column}) == 1, columns))


def _at(message: Message, dictionary: Dictionary | None, index: int, subindex: int) -> Message:
    """Return a message with the identifier that the node has for it, unless it has none, or has it switched off."""
    variable = None if dictionary is None else dictionary.get(index, subindex)
    if variable is None or not is_valid(variable.number):
        return message
    is_extended = bool(variable.number & EXTENDED)
    identifier = variable.number & (0x1FFF_FFFF if is_extended else 0x7FF)
    return replace(message, identifier=identifier, is_extended=is_extended) if identifier else message
