"""Messages of OPC UA as JSON, for other processes and traces.

A number that is not finite, which JSON does not have, is an object with its name: `{"float": "nan"}`.
"""

import json
from dataclasses import fields
from math import isfinite
from typing import Any, Final

from fieldrig.outside.untrusted import MalformedError, field, items, read_json, shown
from fieldrig_bus.opcua.message import (
    LONGEST_PATH,
    LONGEST_TEXT,
    MOST_ARGUMENTS,
    MOST_ELEMENTS,
    MOST_NODES,
    MOST_PATHS,
    AnyValue,
    Argument,
    Browse,
    Call,
    Find,
    Kind,
    Node,
    Nodes,
    Offer,
    OpcUaMessage,
    Outcome,
    Outcomes,
    Read,
    Status,
    Write,
)

LONGEST: Final = 1 << 20
_KINDS: Final = {kind.__name__: kind for kind in (Offer, Browse, Find, Read, Write, Call, Nodes, Outcomes)}
_NOT_FINITE: Final = {"nan": float("nan"), "inf": float("inf"), "-inf": float("-inf")}


def encode(message: OpcUaMessage) -> bytes:
    data = {part.name: _plain(getattr(message, part.name)) for part in fields(message)}
    return json.dumps([type(message).__name__, data], separators=(",", ":")).encode()


def size(part: Node | Outcome) -> int:
    """Return the number of bytes that a part of a message takes."""
    return len(json.dumps(_plain(part), separators=(",", ":"))) + 1


def decode(data: bytes) -> OpcUaMessage:
    """Return the message of `encode`'s bytes.  ValueError for anything else."""
    match read_json(data, LONGEST):
        case [str(kind), dict(fields_)] if kind in _KINDS:
            return _message(kind, fields_)
        case found:
            raise MalformedError(f"not a message of OPC UA: {shown(found)}")


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that the receiver could not read."""
    if type(message) not in _KINDS.values():
        raise TypeError(f"expected a message of OPC UA, found {type(message).__name__}")
    decode(encode(message))


def show(message: OpcUaMessage) -> str:
    """Return a message as one line."""
    match message:
        case Offer(device, about, generation):
            return f"{device} offers its nodes: {about} ({generation})"
        case Read(device, _, paths):
            return f"read {device}: {', '.join(paths)}"
        case Write(device, _, path, value):
            return f"write {device}: {path} = {value!r}"
        case Nodes(_, nodes):
            return f"nodes: {', '.join(node.path for node in nodes)}"
        case Outcomes(_, outcomes):
            return f"outcomes: {', '.join(_shown(outcome) for outcome in outcomes)}"
        case _:
            return f"{type(message).__name__.lower()} {message.device}: {message.path}"


def _shown(outcome: Outcome) -> str:
    return repr(outcome.value) if outcome.status is Status.GOOD else outcome.status.value


def _plain(value: Any) -> Any:
    match value:
        case Kind() | Status():
            return value.value
        case Node() | Outcome() | Argument():
            return {part.name: _plain(getattr(value, part.name)) for part in fields(value)}
        case float() if not isfinite(value):
            return {"float": str(value)}
        case list() | tuple():
            return [_plain(element) for element in value]
        case _:
            return value


def _message(name: str, data: dict[str, Any]) -> OpcUaMessage:
    if name == "Offer":
        generation = field(data, "generation", int)
        return Offer(_text(data, "device"), _text(data, "about", LONGEST_TEXT), generation)
    exchange = field(data, "exchange", int)
    match name:
        case "Nodes":
            nodes = tuple(_node(row) for row in items(field(data, "nodes", list), dict, MOST_NODES, "nodes"))
            return Nodes(exchange, nodes, field(data, "is_complete", bool))
        case "Outcomes":
            outcomes = items(field(data, "outcomes", list), dict, MOST_PATHS, "outcomes")
            return Outcomes(exchange, tuple(_outcome(row) for row in outcomes))
    device = _text(data, "device")
    match name:
        case "Browse":
            return Browse(device, exchange, _text(data, "path"), field(data, "first", int))
        case "Read":
            return Read(device, exchange, tuple(items(field(data, "paths", list), str, MOST_PATHS, "paths")))
        case "Write":
            return Write(device, exchange, _text(data, "path"), _value(data.get("value")))
        case "Call":
            return Call(device, exchange, _text(data, "path"), _values(data, "arguments"))
    return Find(device, exchange, _text(data, "path"))


def _node(data: dict[str, Any]) -> Node:
    choices = items(field(data, "choices", list), list, MOST_ELEMENTS, "choices")
    if any(len(choice) != 2 or type(choice[0]) is not str or type(choice[1]) is not int for choice in choices):
        raise MalformedError("choices: expected names with numbers")
    return Node(
        _text(data, "path"),
        _text(data, "parent"),
        _text(data, "name"),
        _member(Kind, field(data, "kind", str)),
        _text(data, "type"),
        _optional(data, "length", int),
        field(data, "is_writable", bool),
        field(data, "has_children", bool),
        _text(data, "unit"),
        _text(data, "about", LONGEST_TEXT),
        _optional(data, "low", float),
        _optional(data, "high", float),
        tuple((name, number) for name, number in choices),
        _arguments(data, "arguments"),
        _arguments(data, "results"),
    )


def _arguments(data: dict[str, Any], key: str) -> tuple[Argument, ...]:
    return tuple(
        Argument(
            _text(row, "name"), _text(row, "type"), _text(row, "about", LONGEST_TEXT), field(row, "is_array", bool)
        )
        for row in items(field(data, key, list), dict, MOST_ARGUMENTS, key)
    )


def _outcome(data: dict[str, Any]) -> Outcome:
    value = data.get("value")
    status = _member(Status, field(data, "status", str))
    arguments = items(field(data, "arguments", list), str, MOST_ARGUMENTS, "arguments")
    return Outcome(
        status,
        None if value is None else _value(value),
        _text(data, "text", LONGEST_TEXT),
        _values(data, "results"),
        tuple(_member(Status, word) for word in arguments),
    )


def _values(data: dict[str, Any], key: str) -> tuple[AnyValue, ...]:
    values = field(data, key, list)
    if len(values) > MOST_ARGUMENTS:
        raise MalformedError(f"{len(values)} {key}, expected at most {MOST_ARGUMENTS}")
    return tuple(_value(value) for value in values)


def _value(value: Any) -> AnyValue:
    if isinstance(value, list):
        if len(value) > MOST_ELEMENTS:
            raise MalformedError(f"{len(value)} elements, expected at most {MOST_ELEMENTS}")
        return [_single(element) for element in value]
    return _single(value)


def _single(value: Any) -> bool | int | float | str:
    if isinstance(value, dict) and (special := _NOT_FINITE.get(field(value, "float", str))) is not None:
        return special
    if isinstance(value, bool | int | float | str):
        return value
    raise MalformedError(f"expected a value, found {shown(value)}")


def _text(data: dict[str, Any], key: str, longest: int = LONGEST_PATH) -> str:
    text = field(data, key, str)
    if len(text) > longest:
        raise MalformedError(f"{key} of {len(text)} characters, expected at most {longest}")
    return text


def _optional(data: dict[str, Any], key: str, expected: type[Any]) -> Any:
    return None if data.get(key) is None else field(data, key, expected)


def _member(kinds: Any, word: str) -> Any:
    try:
        return kinds(word)
    except ValueError:
        raise MalformedError(f"{shown(word)}: expected one of {[kind.value for kind in kinds]}") from None
