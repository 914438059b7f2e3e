"""The outputs, pins and variables that a program writes, for a device that refuses them to tools and masters.

A value from outside is lost in a variable that each cycle overwrites before it is used.  A variable that the program
uses first, such as a command that it clears or a counter that it adds to, takes such a value, and so does one that it
writes in some cycles only.  Outputs of the controller and pins of instances belong to the program as soon as one
statement writes them.
"""

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Final, NamedTuple

from fieldrig_devices.iec import program as ir
from fieldrig_devices.iec.flow import DATA, OWN, Effects, Flow, Mentioned, Span, is_pin, where_is
from fieldrig_devices.iec.tree import PouKind


class Written(NamedTuple):
    """Places that the statements of a program write.  The spans of one space are in rising order, with gaps."""

    bits: frozenset[tuple[int, int]]
    """Byte and bit of the area %Q."""
    spans: Mapping[str, Sequence[Span]]
    """The variables that each cycle overwrites, and the pins that are set, by space: `DATA`, or an area."""
    blocks: Mapping[str, Sequence[Span]]
    """The same in an instance of each function block, by its name in small letters."""


NOTHING: Final = Written(frozenset(), {}, {})


@dataclass(slots=True)
class Survey:
    """Results of one way through all bodies."""

    mentioned: Mentioned = field(default_factory=Mentioned)
    effects: dict[ir.Pou, Effects] = field(default_factory=dict)
    outside: dict[ir.Pou, Effects] = field(default_factory=dict)


def surveyed(callees_first: Iterable[ir.Pou]) -> Survey:
    """Go once through the bodies, which are there until the program is lowered; addresses have been set."""
    survey = Survey()
    for pou in callees_first:
        effects = Flow(pou, survey.effects, survey.outside, survey.mentioned).effects()
        survey.effects[pou], survey.outside[pou] = effects, effects.outside()
    return survey


def written_by(program: ir.Program, survey: Survey) -> Written:
    bits, pins = set[tuple[int, int]](), dict[str, set[Span]]()
    for pou, place in survey.mentioned.targets:
        if isinstance(place, ir.Located) and place.area == "Q":
            bits |= set(_bits(place))
        elif is_pin(place) and (where := where_is(pou, place)) is not None:
            pins.setdefault(_block(pou) if where.span.space == OWN else DATA, set()).add(where.span)
    pointed = survey.mentioned.pointed
    spans = set(pins.pop(DATA, ()))
    for task in program.tasks:
        if task.kind is not ir.TaskKind.EVENT:
            spans |= _lost(_sequence(survey.effects[pou] for pou in task.programs), pointed)
    blocks = pins
    for pou, effects in survey.effects.items():
        if pou.kind is PouKind.FUNCTION_BLOCK and pou.owner is None:
            own = {span for span in _lost(effects, pointed) if span.space == OWN}
            blocks.setdefault(_block(pou), set()).update(own)
    return Written(
        frozenset(bits),
        {space: tuple(parts) for space, parts in _by_space(spans).items()},
        {name: tuple(_merged(parts)) for name, parts in blocks.items() if parts},
    )


def _block(pou: ir.Pou) -> str:
    while pou.owner is not None:
        pou = pou.owner
    return pou.name.casefold()


def _bits(place: ir.Located) -> Iterator[tuple[int, int]]:
    if place.bit >= 0:
        yield place.byte, place.bit
        return
    yield from ((place.byte + byte, bit) for byte in range(place.type.size) for bit in range(8))


def _sequence(parts: Iterable[Effects]) -> Effects:
    """Return the effects of the programs of a task, one after the other."""
    overwritten, used = set[Span](), set[Span]()
    for part in parts:
        used |= part.used - overwritten
        overwritten |= part.overwritten
    return Effects(frozenset(overwritten), frozenset(used))


def _lost(effects: Effects, pointed: Iterable[Span]) -> set[Span]:
    """Return where a value from outside is lost: what is overwritten, and neither used before nor by a pointer."""
    used = _by_space((*effects.used, *pointed))
    return {span for span in effects.overwritten if not overlap(used.get(span.space, ()), span.start, span.end)}


def _by_space(spans: Iterable[Span]) -> dict[str, list[Span]]:
    by_space: dict[str, list[Span]] = {}
    for span in spans:
        by_space.setdefault(span.space, []).append(span)
    return {space: _merged(some) for space, some in by_space.items()}


def _merged(spans: Iterable[Span]) -> list[Span]:
    """Return the spans of one space in rising order, without those that touch another one."""
    merged: list[Span] = []
    for span in sorted(spans):
        if merged and span.start <= merged[-1].end:
            merged[-1] = merged[-1]._replace(end=max(merged[-1].end, span.end))
        else:
            merged.append(span)
    return merged


def overlap(spans: Sequence[Span], start: int, end: int) -> bool:
    """Return whether one of the spans, which are in rising order, has a part between `start` and `end`."""
    after = bisect_left(spans, end, key=attrgetter("start"))
    return after > 0 and spans[after - 1].end > start
