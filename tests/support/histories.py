"""Histories of a rig: what a bad day brings, by chance, and whether all that answered before answers after it.

A history is up to eight faults, power cycles, written points and messages of a foreign master, in a branch of the rig.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from random import Random
from types import SimpleNamespace
from typing import Any, Final, NamedTuple

from fieldrig import Rig
from fieldrig.clock import MS, S
from fieldrig.errors import RigError
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.search.fault_choices import fault_choices

MOST_ACTS: Final = 8
SPAN_NS: Final = 4 * S
"""The time in which a history happens."""
AFTER_NS: Final = 8 * S
"""The time that the rig has to come back."""
ANSWER_NS: Final = 1 * S
FAULTS: Final = SimpleNamespace(where=["*"], kinds=["*"], durations=[20 * MS, 700 * MS], when=[], given={})
OBJECTS: Final = ("1000:00", "1001:00", "1010:01", "1017:00", "6040:00", "6041:00", "6060:00", "607A:00", "2FFF:01")
COMMANDS: Final = (0x01, 0x02, 0x80, 0x81, 0x82)
REQUESTS: Final = (
    "03 0000 0001",
    "04 0000 0002",
    "06 0000 0001",
    "05 0000 ff00",
    "10 0001 0001 02 1234",
    "2b 0e 01 00",
    "11",
)
UNITS: Final = range(1, 12)


class Act(NamedTuple):
    """A thing that happens at an instant after the beginning."""

    at_ns: int
    verb: str
    where: str
    value: Any = None


class Outcome(NamedTuple):
    hash: str
    lost: tuple[str, ...]
    """Nodes and units that do not answer any more."""


def acts_of(rig: Rig) -> list[Act]:
    """Return all that may happen to a rig that is thrown away after it, at the instant 0."""
    faults = [Act(0, "fault", one.where, value) for one in fault_choices(rig, FAULTS) for value in one.values]
    restarts = [Act(0, "restart", device) for device in rig.config.devices]
    return faults + restarts


def history(rig: Rig, possible: Sequence[Act], dice: Random) -> list[Act]:
    """Return what happens by these dice, in its order: as many faults as points, messages and power cycles together."""
    found = []
    for _ in range(dice.randint(1, MOST_ACTS)):
        kind = dice.random()
        if kind < 0.5:
            act: Act | None = dice.choice(possible)
        else:
            act = _written(rig, dice) if kind < 0.75 else _sent(rig, dice)
        if act is not None:
            found.append(act._replace(at_ns=dice.randrange(SPAN_NS // MS) * MS))
    return sorted(found, key=lambda act: act.at_ns)


def played(rig: Rig, history: Sequence[Act], expected: Sequence[str]) -> Outcome:
    """Play a history, end all faults, and ask those who are expected to answer: after it, and after a power cycle."""
    rig.trace_hash()
    begin_ns, stranger = rig.now_ns, rig.attach("stranger")
    for act in history:
        rig.run_until(max(rig.now_ns, begin_ns + act.at_ns))
        with suppress(RigError):  # it may be refused; what a device raises is none
            _do(rig, stranger, act)
    for where in (*rig.buses, *rig.config.devices):
        for number in rig.faults(where):
            rig.clear_fault(where, number)
    rig.run_for(AFTER_NS)
    lost = [name for name in expected if name not in answering(rig)]
    if lost:
        for device in rig.config.devices:
            rig.restart(device)
        rig.run_for(AFTER_NS)
        lost = [name for name in expected if name not in answering(rig)]
    return Outcome(rig.trace_hash(), tuple(lost))


def answering(rig: Rig) -> list[str]:
    """Return the nodes of CAN buses that answer to SDO, and the units of Modbus buses that answer."""
    found: dict[str, None] = {}
    asker = rig.attach(f"asker{rig.now_ns}")
    for bus in _buses(rig, "can"):
        link = asker.link(bus)

        def on_frame(frame: Any, bus: str = bus) -> None:
            if isinstance(frame, CanFrame) and frame.identifier & 0x780 == 0x580:
                found[f"{bus} node {frame.identifier & 0x7F}"] = None

        link.on_receive(on_frame)
        for node in range(1, 128):
            link.send(CanFrame(0x600 + node, bytes.fromhex("40 00 10 00 00 00 00 00")))
    for bus in _buses(rig, "modbus"):
        link = asker.link(bus)

        def on_response(response: Any, bus: str = bus) -> None:
            if isinstance(response, ModbusResponse):
                found[f"{bus} unit {response.unit}"] = None

        link.on_receive(on_response)
        for unit in UNITS:
            link.send(ModbusRequest(unit, bytes.fromhex("03 0000 0001"), unit))
            rig.run_for(ANSWER_NS // len(UNITS))
    rig.run_for(ANSWER_NS)
    rig.detach(asker.name)
    return list(found)


def _do(rig: Rig, stranger: Any, act: Act) -> None:
    match act.verb:
        case "fault":
            rig.add_fault(act.where, act.value)
        case "restart":
            rig.restart(act.where)
        case "set":
            rig.set(act.where, act.value)
        case _:
            stranger.link(act.where).send(act.value)


def _buses(rig: Rig, family: str) -> Iterator[str]:
    return (name for name, bus in rig.buses.items() if type(bus).family == family)


def _written(rig: Rig, dice: Random) -> Act | None:
    device = dice.choice(list(rig.config.devices))
    facts = {key: fact for key, fact in rig.facts(device).items() if fact["writable"]}
    if not facts:
        return None
    key = dice.choice(list(facts))
    return Act(0, "set", f"{device}/{key}", _value(rig.values(device, [key])[key], facts[key], dice))


def _value(present: Any, fact: Mapping[str, Any], dice: Random) -> Any:
    low, high = fact.get("low"), fact.get("high")
    if isinstance(present, bool):
        return not present
    if isinstance(present, str):
        return dice.choice(["", "0", "x" * 40, present])
    if low is not None and high is not None:
        return dice.choice([low, high, dice.randint(int(low), int(high))])
    wide = dice.choice([0, 1, -1, 3.5, 1e9, -1e9])
    return int(wide) if isinstance(present, int) else float(wide)


def _sent(rig: Rig, dice: Random) -> Act | None:
    buses = [*_buses(rig, "can"), *_buses(rig, "modbus")]
    if not buses:
        return None
    bus = dice.choice(buses)
    if type(rig.buses[bus]).family == "modbus":
        request = bytes.fromhex(dice.choice(REQUESTS))
        return Act(0, "send", bus, ModbusRequest(dice.choice(UNITS), request, dice.randrange(1 << 16)))
    node = dice.randint(1, 12)
    kind = dice.randrange(3)
    if kind == 0:
        return Act(0, "send", bus, CanFrame(0, bytes([dice.choice(COMMANDS), dice.choice([0, node])])))
    if kind == 1:
        index, subindex = dice.choice(OBJECTS).split(":")
        command = dice.choice(["40", "23", "2B", "2F"])
        data = bytes.fromhex(command) + int(index, 16).to_bytes(2, "little") + bytes([int(subindex, 16)])
        return Act(0, "send", bus, CanFrame(0x600 + node, data + dice.choice([bytes(4), dice.randbytes(4), b"save"])))
    identifier = dice.choice([0x80, 0x200, 0x300, 0x400, 0x500]) + node
    return Act(0, "send", bus, CanFrame(identifier, dice.randbytes(dice.randint(0, 8))))
