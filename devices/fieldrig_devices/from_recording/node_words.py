"""The facts that a recording has of a node, and those that it lacks, in sentences for the rig file."""

from collections.abc import Iterator
from statistics import median
from typing import Final

from fieldrig.clock import S
from fieldrig.points.values import counted
from fieldrig.traces.instants import span
from fieldrig_devices.canopen.emcy_words import emcy_words
from fieldrig_devices.canopen.nmt import Command
from fieldrig_devices.from_recording.layout import BYTES
from fieldrig_devices.from_recording.node_model import NodeModel, PdoModel, runs_by_itself
from fieldrig_devices.from_recording.objects import ObjectLog
from fieldrig_devices.from_recording.rhythm import FEWEST, period_of

IDENTITY: Final = (("device type", 0x1000, 0), ("vendor", 0x1018, 1), ("product", 0x1018, 2), ("revision", 0x1018, 3))
MOST_LISTED: Final = 6


def seen(model: NodeModel, start_ns: int) -> Iterator[str]:
    """Yield what the recording says; it begins at `start_ns`."""
    objects, life = model.log.objects, model.log.life
    name = objects.by_key.get((0x1008, 0))
    known = [f"{word} {value:X}h" for word, *key in IDENTITY if (value := objects.first_number(*key)) is not None]
    if name is not None and name.last is not None:
        known.insert(0, f'"{_printable(name.last)}"')
    yield f"node {model.node_id}: {', '.join(known) or 'its identity was not read'}"
    yield from _life(model, start_ns)
    yield from map(_pdo, model.pdos)
    yield from model.decisions
    there = objects.there().values()
    reads, writes = (sum(map(is_so, there)) for is_so in (_is_read, _is_written))
    if reads or writes:
        words = f"SDO: {counted(reads, 'object')} read, {writes} written"
        if objects.answer_ns:
            usual_ns, longest_ns = round(median(objects.answer_ns)), max(objects.answer_ns)
            words += f"; it answers after {span(usual_ns)}, at most {span(longest_ns)}"
        yield words
    if life.emergencies:
        firsts = [f"{emcy_words(_data(code, register), is_drive=model.is_drive)} at {_at(instant, start_ns)}"
                  for instant, code, register, _ in life.emergencies[:MOST_LISTED]]  # fmt: skip
        more = life.emergency_count - len(firsts)
        yield f"EMCY: {', '.join(firsts)}{f' and {more} more' if more else ''}; its faults send them again"


def unknown(model: NodeModel) -> Iterator[str]:
    """Yield what is not known."""
    yield from model.remarks
    objects, life = model.log.objects, model.log.life
    if not model.is_described:
        yield (
            "objects that no master read or wrote: they do not exist here (abort 0602 0000h)"
            if not model.is_drive
            else (
                "objects that no master read or wrote: those of CiA 402 are as in a drive of ours, others do not exist"
            )
        )
    changed = [
        f"{word} {first:X}h, later {last:X}h"
        for word, *key in IDENTITY
        if (first := objects.first_number(*key)) is not None and (last := objects.number(*key)) not in (None, first)
    ]
    if changed:
        yield f"why its identity changed, as if it was replaced: {'; '.join(changed)}; here it is the first"
    both = [f"{index:04X}:{sub:02X}" for (index, sub), log in objects.there().items() if _is_rewritten(log)]
    if both:
        more = len(both) - MOST_LISTED
        listed = ", ".join(both[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")
        them = "it was" if len(both) == 1 else "they were"
        yield f"written after {them} read: {listed}; the node begins with the value before"
    announced = [f"{index:04X}:{sub:02X}" for (index, sub), log in objects.there().items() if _is_announced(log)]
    if announced:
        yield f"the content of {', '.join(announced[:MOST_LISTED])}: its transfer was not finished, so it is zeros"
    if not life.boots:
        yield "its boot-up, because the recording begins later, or it was not switched on"
        yield from _of_the_middle(model)
    if not life.heartbeats and not life.answers:
        yield "its NMT state, because it sent no heartbeat, and no master guarded it"
    if not (life.boots or model.pdos or objects.by_key or life.emergencies):
        yield "whether it is a device or the master: nothing but its heartbeat was seen"
    if objects.unanswered:
        yield f"why {counted(objects.unanswered, 'SDO request')} had no answer"
    if objects.left_out:
        yield f"{counted(objects.left_out, 'transfer')} of further objects, which are too many"
    for key, column in model.columns.items():
        if column.left_out:
            yield f"{key} changed {counted(column.left_out, 'time')} more than its column has"


def _of_the_middle(model: NodeModel) -> Iterator[str]:
    """Yield what only a recording from the boot-up on would show."""
    if model.is_drive:
        yield "its state before the recording: it begins as after power-on, in 'switch on disabled'"
    for pdo in model.pdos:
        if pdo.rhythm is not None and pdo.rhythm.is_synchronous and pdo.rhythm.type > 1:
            yield f"at which SYNC {pdo.pdo.name} begins to count"


def _life(model: NodeModel, start_ns: int) -> Iterator[str]:
    life = model.log.life
    boots = [
        f"at {_at(boot.instant_ns, start_ns)}"
        + (f", {span(boot.took_ns)} after {_reset(boot.command)}" if boot.command is not None else "")
        for boot in life.boots
    ]
    if boots:
        more = len(boots) - MOST_LISTED
        yield f"boot-up {'; '.join(boots[:MOST_LISTED])}{f' and {more} more' if more > 0 else ''}"
    if life.heartbeats:
        count = len(life.heartbeats)
        yield f"heartbeat every {span(life.heartbeat_ns)}" if count > 1 else "a single heartbeat"
    if life.answers:
        yield f"node guarding every {span(life.guarding_ns)} by the master"
    if runs_by_itself(model.log, model.pdos):
        yield "it is operational without a command of the recording, so it starts by itself (1F80h)"


def _pdo(model: PdoModel) -> str:
    words = f"{model.pdo.name}, {model.identifier:03X}h, {counted(model.log.length, 'byte')}"
    if len(model.log.lengths) > 1:
        words += (
            f" (also {', '.join(str(length) for length in sorted(model.log.lengths) if length != model.log.length)})"
        )
    words += f": {_received(model) if model.rhythm is None else model.rhythm.words}"
    unnamed = next((part for part in model.layout.parts if part.object in BYTES), None)
    if unnamed is not None and not model.layout.is_known:
        is_begun = unnamed is not model.layout.parts[0]
        mapping, them = ("the end of its mapping", "the bytes there") if is_begun else ("its mapping", "its bytes")
        words += f"; {mapping} is not known, so {them} are {unnamed.object:04X}h"
    if model.layout.is_assumed:
        words += "; no master has read its mapping, and that of CiA 402 fits"
    return words


def _received(model: PdoModel) -> str:
    """Return how often a master has sent a PDO."""
    words = f"received {counted(model.log.count, 'time')}"
    period_ns = period_of(model.log.instants)
    return f"{words}, every {span(period_ns)}" if model.log.count >= FEWEST else words


def _is_read(log: ObjectLog) -> bool:
    return log.is_read


def _is_announced(log: ObjectLog) -> bool:
    return not log.is_read and not log.is_written


def _is_written(log: ObjectLog) -> bool:
    return log.is_written


def _is_rewritten(log: ObjectLog) -> bool:
    return log.first is not None and log.is_written and log.first != log.last


def _reset(command: Command) -> str:
    return "reset node" if command is Command.RESET_NODE else "reset communication"


def _at(instant_ns: int, start_ns: int) -> str:
    return f"{(instant_ns - start_ns) / S:.3f} s"


def _printable(data: bytes) -> str:
    return "".join(chr(byte) if 0x20 <= byte < 0x7F else "?" for byte in data.rstrip(b"\0"))[:60]


def _data(code: int, register: int) -> bytes:
    return code.to_bytes(2, "little") + bytes((register, 0, 0, 0, 0, 0))
