"""Actions, routines, tasks and sequences (chapter 3 of the manual)."""

from fieldrig_devices.pam.language.items import Actions, Event, Parameter, Reaction, Routine, Routines, Sequence, Task
from fieldrig_devices.pam.language.objects import SPECS
from fieldrig_devices.pam.language.parser.cursor import Cursor
from fieldrig_devices.pam.language.parser.declarations import parameters
from fieldrig_devices.pam.language.parser.expressions import expression
from fieldrig_devices.pam.language.parser.statements import body, sequence_name
from fieldrig_devices.pam.language.tree import Statement


def actions(cursor: Cursor) -> Actions:
    place, begin = cursor.place, cursor.i
    cursor.expect("ACTIONS")
    name = cursor.name("the name of the actions")
    cursor.semicolon()
    specs = _specs(cursor, "ACTIONS")
    reactions: list[Reaction] = []
    while cursor.is_word("ON_EVENT", "ON_STATE"):
        reactions.append(_reaction(cursor))
    power_on = _power_on(cursor)
    cursor.close("END_ACTIONS", begin)
    cursor.accept(";")
    return Actions(place, name, specs, tuple(reactions), power_on)


def _specs(cursor: Cursor, kind: str) -> tuple[Parameter, ...]:
    begin = cursor.i
    if not cursor.accept("SPECS"):
        return ()
    known = len(cursor.mistakes)
    specs = parameters(cursor, kind, SPECS[kind], ("END_SPECS",), [])
    is_right = len(cursor.mistakes) == known
    if is_right and kind == "TASK" and not any(parameter.name == "CYCLES" for parameter in specs):
        cursor.wrong(cursor.tokens[begin].place, "the SPECS of the task have no CYCLES", "CYCLES = n")
    cursor.close("END_SPECS", begin)
    cursor.accept(";")
    return specs


def _reaction(cursor: Cursor) -> Reaction:
    place, begin = cursor.place, cursor.i
    is_event = cursor.is_word("ON_EVENT")
    cursor.take()
    condition = expression(cursor)
    cursor.expect("ACTION")
    cursor.accept(";")
    statements = body(cursor)
    cursor.close("END_ACTION", begin)
    cursor.accept(";")
    return Reaction(place, "ON_EVENT" if is_event else "ON_STATE", condition, statements)


def _power_on(cursor: Cursor) -> tuple[Statement, ...] | None:
    begin = cursor.i
    if not cursor.accept("POWERON"):
        return None
    cursor.item_index()
    cursor.accept(";")
    statements = body(cursor)
    cursor.close("END_POWERON", begin)
    cursor.accept(";")
    return statements


def routines(cursor: Cursor) -> Routines:
    place, begin = cursor.place, cursor.i
    cursor.expect("ROUTINES")
    name = cursor.name("the name of the routines")
    cursor.semicolon()
    all_routines: list[Routine] = []
    while cursor.is_word("ROUTINE"):
        all_routines.append(_routine(cursor))
    power_on = _power_on(cursor)
    cursor.close("END_ROUTINES", begin)
    cursor.accept(";")
    return Routines(place, name, tuple(all_routines), power_on)


def _routine(cursor: Cursor) -> Routine:
    place, begin = cursor.place, cursor.i
    cursor.expect("ROUTINE")
    name = cursor.name("the name of the routine")
    formals: list[str] = []
    if cursor.accept("WITH"):
        formals.append(cursor.name("the name of a parameter"))
        while cursor.accept(","):
            formals.append(cursor.name("the name of a parameter"))
    cursor.semicolon()
    statements = body(cursor)
    cursor.close("END_ROUTINE", begin)
    cursor.accept(";")
    return Routine(place, name, tuple(formals), statements)


def task(cursor: Cursor) -> Task:
    place, begin = cursor.place, cursor.i
    cursor.expect("TASK")
    name = cursor.name("the name of the task")
    cursor.semicolon()
    specs = _specs(cursor, "TASK")
    events: list[Event] = []
    first = cursor.i
    if cursor.accept("EVENTS"):
        while cursor.is_word("ON_EVENT"):
            events.append(_event(cursor))
        cursor.close("END_EVENTS", first)
        cursor.accept(";")
    sequences: list[Sequence] = []
    while cursor.is_word("SEQUENCE"):
        sequences.append(_sequence(cursor))
    power_on = _power_on(cursor)
    cursor.close("END_TASK", begin)
    cursor.accept(";")
    return Task(place, name, specs, tuple(events), tuple(sequences), power_on)


def _event(cursor: Cursor) -> Event:
    place = cursor.place
    cursor.take()
    condition = expression(cursor)
    cursor.expect("XEQ_SEQUENCE")
    event = Event(place, condition, sequence_name(cursor))
    cursor.semicolon()
    return event


def _sequence(cursor: Cursor) -> Sequence:
    place, begin = cursor.place, cursor.i
    cursor.expect("SEQUENCE")
    name = cursor.name("the name of the sequence")
    is_multiple = cursor.item_index()
    cursor.semicolon(is_optional=True)
    specs = _specs(cursor, "SEQUENCE")
    statements = body(cursor)
    cursor.close("END_SEQUENCE", begin)
    cursor.accept(";")
    return Sequence(place, name, is_multiple, specs, statements)
