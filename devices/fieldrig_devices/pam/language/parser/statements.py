"""Statements: object access, flow control, and the service statements that suspend a sequence (section 1.4)."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, Literal

from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import EXECUTIVE_NAMES, MATHEMATICS, REPLACED
from fieldrig_devices.pam.language.parser.cursor import Cursor, UnexpectedError
from fieldrig_devices.pam.language.parser.expressions import (
    AS_IN,
    arguments,
    expression,
    function_name,
    object_or_parameter,
    reference,
    routine_call,
)
from fieldrig_devices.pam.language.reserved import ITEMS
from fieldrig_devices.pam.language.words import STRUCTURE

_ENDS: Final = frozenset(word for word in STRUCTURE if word.startswith("END")) | {
    "ELSE",
    "POWERON",
    "SEQUENCE",
    "ROUTINE",
    "ON_EVENT",
    "ON_STATE",
    "ELSIF",
    "ELSEIF",
    "ELIF",
}
"""Words that end a list of statements, also where one is missing."""
_ELSE_IF: Final = ("ELSIF", "ELSEIF", "ELIF")
_OTHER_LOOPS: Final = ("WHILE", "FOR", "REPEAT", "DO")
_OTHER_ENDS: Final = ("END_WHILE", "END_FOR", "END_REPEAT", "UNTIL", "ENDWHILE", "ENDFOR")
_OTHER_JUMPS: Final = ("GOTO", "JMP", "RETURN", "EXIT", "BREAK", "CONTINUE")
_OTHER_WAITS: Final = ("WAIT", "DELAY", "SLEEP", "PAUSE")
_LEVELS_OF_FLAGS: Final = {"ON": "set", "HIGH": "set", "YES": "set", "OFF": "reset", "LOW": "reset", "NO": "reset"}
_BEGINS: Final = {"END_IF": "IF", "ELSE": "IF", "END_LOOP": "LOOP", "END_CASE": "CASE"}
"""The words that end what is in a body, and what they end."""
_OPERATORS: Final = ("+", "-", "*", "/", "%")
_UNITS: Final = ("ms", "s", "sec", "min")
MOST_STATEMENTS: Final = 20_000
"""Statements of one list."""


def statements(cursor: Cursor) -> tuple[tree.Statement, ...]:
    """Read statements up to a word that ends them.  A mistake in one does not hide those in the next."""
    body: list[tree.Statement] = []
    while not cursor.is_at_end and not cursor.is_word(*_ENDS) and not begins_item(cursor):
        if cursor.accept(";"):
            continue
        if len(body) >= MOST_STATEMENTS:
            raise cursor.unexpected(f"at most {MOST_STATEMENTS} statements in one list")
        begin, depth = cursor.i, cursor.depth
        try:
            body.append(statement(cursor))
        except UnexpectedError:
            cursor.recover(begin, depth, ";", *_ENDS, *_STATEMENTS)
            cursor.accept(";")
    return tuple(body)


def body(cursor: Cursor) -> tuple[tree.Statement, ...]:
    """Read the statements of a sequence or routine, and report a word in it that ends nothing."""
    before = len(cursor.mistakes)
    read = statements(cursor)
    while cursor.is_word(*_BEGINS):
        word = cursor.token.text.upper()
        if len(cursor.mistakes) == before:
            cursor.wrong(cursor.place, f"{word} has no {_BEGINS[word]} in front of it")
        cursor.take()
        if word == "END_LOOP":  # its condition
            cursor.skip_to(";", *_ENDS)
        read += statements(cursor)
    return read


def begins_item(cursor: Cursor) -> bool:
    """True in front of a declaration or program, such as NODE NOD_a."""
    return cursor.is_word(*ITEMS) and cursor.following.kind == "name"


def statement(cursor: Cursor) -> tree.Statement:
    cursor.deeper()
    word = cursor.token.text.upper()
    read = _STATEMENTS.get(word) if cursor.is_word(word) else None
    parsed = read(cursor) if read is not None else _access(cursor)
    cursor.higher()
    return parsed


def _access(cursor: Cursor) -> tree.Statement:
    """Read a statement that begins with the name of an object."""
    place = cursor.place
    if cursor.is_word(*_OTHER_LOOPS, *_OTHER_ENDS) and not cursor.is_next("<-", "?", ":", "<<"):
        raise cursor.unexpected(
            "a statement", "There is one loop: LOOP, its statements, and END_LOOP with a condition."
        )
    if cursor.is_word(*_OTHER_JUMPS) and not cursor.is_next("<-", "?", ":", "<<"):
        raise cursor.unexpected(
            "a statement", "There are no jumps: a sequence goes on in another one by XEQ_SEQUENCE, and ends at its end."
        )
    if cursor.is_word(*_OTHER_WAITS) and cursor.following.kind in ("integer", "real"):
        raise cursor.unexpected("WAIT_TIME")
    if cursor.token.text in ("+", "-") and cursor.is_next(cursor.token.text):  # ++M
        name = cursor.tokens[min(cursor.i + 2, len(cursor.tokens) - 1)].text
        raise cursor.unexpected("a statement", AS_IN.format(name=name, sign=cursor.token.text))
    target = object_or_parameter(cursor)
    if isinstance(target, tree.ParameterOf):
        cursor.expect("<-")
        is_routine = target.parameter.endswith("ROUTINE")
        value = routine_call(cursor) if is_routine else expression(cursor)
        cursor.semicolon()
        return tree.Modify(place, target, value)
    if cursor.token.text == "<<":
        return _pipe(cursor, target)
    if cursor.accept("?"):
        asked = tree.Inquiry(cursor.place, target, function_name(cursor), arguments(cursor))
        cursor.semicolon()
        return tree.Ask(place, asked)
    if not cursor.accept("<-") and not _point(cursor):
        raise cursor.unexpected("<-", _hint(target.name, cursor.token.text))
    if cursor.is_word(*_LEVELS_OF_FLAGS) and cursor.is_next(";"):
        level = _LEVELS_OF_FLAGS[cursor.token.text.upper()]
        cursor.wrong(cursor.place, f"got {cursor.token.text}", level)
        cursor.tokens[cursor.i] = replace(cursor.token, text=level)
    word = cursor.token.text.lower()
    is_function = cursor.token.kind == "name" and word in EXECUTIVE_NAMES | REPLACED.keys()
    if word in MATHEMATICS and cursor.is_next("("):
        raise cursor.unexpected(f"a value in front of ? {word}, as in 2 ? {word}")
    is_call = cursor.token.kind == "name" and cursor.is_next("(")  # also of a function that no object has
    if is_function and word not in REPLACED and cursor.following.kind in ("integer", "real"):
        cursor.take()
        cursor.missing("(")
        raise UnexpectedError
    if is_call or (is_function and cursor.is_next(";") and not cursor.is_name(cursor.token)):
        assignment: tree.Statement = tree.Execute(place, target, function_name(cursor), arguments(cursor))
    else:
        assignment = tree.Assign(place, target, expression(cursor))
    cursor.semicolon()
    return assignment


def _point(cursor: Cursor) -> bool:
    """Pass over the point of other languages in front of a function, as in AXI_Belt.stop."""
    if cursor.token.text != "." or cursor.following.text.lower() not in EXECUTIVE_NAMES:
        return False
    cursor.wrong(cursor.take().place, "got .", "<-")
    return True


def _hint(name: str, following: str) -> str:
    """Return the hint for a name that is not followed by what a statement needs."""
    from difflib import get_close_matches

    if following in _OPERATORS:  # such as M++ or M += 2
        return AS_IN.format(name=name, sign=following)
    if following == "(":
        return f"A routine is called as in CALL {name} WITH 1, 2;"
    close = get_close_matches(name.upper(), (*_STATEMENTS, *_ENDS), 1, 0.75)
    form = "A statement is object <- value, object <- function, or object:PARAMETER <- value."
    return f"Perhaps {close[0]} is meant." if close else form


def _pipe(cursor: Cursor, output: tree.Reference) -> tree.Connect:
    blocks = [output]
    while cursor.accept("<<"):
        blocks.append(reference(cursor))
    cursor.semicolon()
    return tree.Connect(output.place, tuple(blocks))


def _call(cursor: Cursor) -> tree.Call:
    place = cursor.place
    cursor.take()
    called = routine_call(cursor)
    cursor.semicolon()
    return tree.Call(place, called)


def _then(cursor: Cursor) -> None:
    """Pass over THEN, also where it is spelled wrong in front of a statement."""
    from difflib import get_close_matches

    word = cursor.token.text
    is_alike = word.upper() == "DO" or bool(get_close_matches(word.upper(), ("THEN",), 1, 0.7))
    if cursor.token.kind == "name" and is_alike and not cursor.is_word("THEN") and not cursor.is_next("<-", "?", ":"):
        cursor.wrong(cursor.place, f"got {word}", "THEN", "")
        cursor.take()
    else:
        cursor.close("THEN")


def _time(cursor: Cursor) -> tree.Expression:
    """Read a time, whose unit is always the millisecond."""
    time = expression(cursor)
    if cursor.token.kind == "name" and cursor.token.text.lower() in _UNITS and not cursor.is_next("<-", "?", ":"):
        cursor.wrong(cursor.place, f"got {cursor.token.text}", "a number of milliseconds without a unit", "")
        cursor.take()
    return time


def _if(cursor: Cursor) -> tree.If:
    place, begin = cursor.place, cursor.i
    cursor.take()
    condition = expression(cursor)
    _then(cursor)
    then = statements(cursor)
    if cursor.is_word(*_ELSE_IF):
        hint = "An IF inside the ELSE has an END_IF of its own."
        cursor.wrong(cursor.place, f"got {cursor.token.text}", "ELSE IF ... END_IF", hint)
        cursor.deeper()
        rest = _if(cursor)  # both end at one END_IF
        cursor.higher()
        return tree.If(place, condition, then, (rest,))
    otherwise = statements(cursor) if cursor.accept("ELSE") else ()
    cursor.close("END_IF", begin)
    cursor.accept(";")
    return tree.If(place, condition, then, otherwise)


def _loop(cursor: Cursor) -> tree.Loop:
    place, begin = cursor.place, cursor.i
    cursor.take()
    body = statements(cursor)
    if not cursor.is_word("END_LOOP"):
        cursor.close("END_LOOP", begin)
        return tree.Loop(place, body, tree.Number(place, 1))
    cursor.close("END_LOOP", begin)
    if cursor.token.text == ";" or cursor.is_word(*_ENDS, *_STATEMENTS):
        cursor.missing("a condition", "The loop ends when it is met, as in END_LOOP M = 5;")
        cursor.accept(";")
        return tree.Loop(place, body, tree.Number(place, 1))
    until = expression(cursor)
    cursor.semicolon()
    return tree.Loop(place, body, until)


def sequence_name(cursor: Cursor) -> tree.SequenceRef:
    place = cursor.place
    name = cursor.name("the name of a sequence")
    return tree.SequenceRef(place, name, cursor.item_index())


def _start_sequence(cursor: Cursor) -> tree.StartSequence:
    place = cursor.place
    cursor.take()
    start = tree.StartSequence(place, sequence_name(cursor))
    cursor.semicolon(is_optional=True)
    return start


def _task_and_sequence(cursor: Cursor) -> tree.StartTask:
    place = cursor.place
    cursor.take()
    task = cursor.name("the name of a task")
    cursor.expect("SEQUENCE")
    sequence = sequence_name(cursor)
    modes: tuple[Literal["WAIT", "ABORT"], ...] = ("WAIT", "ABORT")
    mode: Literal["", "WAIT", "ABORT"] = next((word for word in modes if cursor.accept(word)), "")
    return tree.StartTask(place, task, sequence, mode)


def _start_task(cursor: Cursor) -> tree.StartTask:
    start = _task_and_sequence(cursor)
    cursor.semicolon()
    return start


def _condition(cursor: Cursor) -> tree.Statement:
    place = cursor.place
    cursor.take()
    if cursor.accept("DUPL_START"):
        cursor.semicolon()
        return tree.DuplicateStart(place)
    condition = expression(cursor)
    timeout = _time(cursor) if cursor.accept("TIMEOUT") else None
    cursor.semicolon()
    return tree.Condition(place, condition, timeout)


def _wait(cursor: Cursor) -> tree.Wait:
    place = cursor.place
    cursor.take()
    wait = tree.Wait(place, _time(cursor))
    cursor.semicolon()
    return wait


def _case(cursor: Cursor) -> tree.Case:
    place, begin = cursor.place, cursor.i
    cursor.take()
    branches: list[tree.Branch] = []
    while cursor.accept("CONDITION"):
        branches.append(_branch(cursor))
    if not branches:
        hint = "A case is as in CASE CONDITION M = 1 XEQ_SEQUENCE SEQ_One; END_CASE"
        raise cursor.unexpected("CONDITION", hint)
    timeout = _branch(cursor) if cursor.accept("TIMEOUT") else None
    cursor.close("END_CASE", begin)
    cursor.accept(";")
    return tree.Case(place, tuple(branches), timeout)


def _branch(cursor: Cursor) -> tree.Branch:
    place = cursor.place
    condition = expression(cursor)
    cursor.expect("XEQ_SEQUENCE")
    branch = tree.Branch(place, condition, sequence_name(cursor))
    cursor.semicolon()
    return branch


def _exception(cursor: Cursor) -> tree.ArmException:
    place = cursor.place
    cursor.take()
    condition = expression(cursor)
    has_timeout = cursor.accept("TIMEOUT")
    is_inherited = not has_timeout or cursor.is_word("SEQUENCE", "ENTRY", "XEQ_TASK", "ABORT_SEQUENCE")
    timeout = None if is_inherited else _time(cursor)
    action = _exception_action(cursor)
    cursor.semicolon()
    return tree.ArmException(place, condition, action, has_timeout, timeout)


def _exception_action(cursor: Cursor) -> tree.ExceptionAction:
    place = cursor.place
    if cursor.accept("SEQUENCE"):
        return tree.StartSequence(place, sequence_name(cursor))
    if cursor.accept("ENTRY"):
        return tree.EntryAction(place, cursor.name("the label of an EXCEPTION_ENTRY"))
    if cursor.accept("ABORT_SEQUENCE"):
        return tree.AbortAction(place)
    if cursor.is_word("XEQ_TASK"):
        return _task_and_sequence(cursor)
    raise cursor.unexpected("SEQUENCE, ENTRY, XEQ_TASK or ABORT_SEQUENCE")


def _exception_entry(cursor: Cursor) -> tree.ExceptionEntry:
    place = cursor.place
    cursor.take()
    entry = tree.ExceptionEntry(place, cursor.name("a label"))
    cursor.semicolon()
    return entry


def _remove_exception(cursor: Cursor) -> tree.RemoveException:
    place = cursor.place
    cursor.take()
    cursor.semicolon(is_optional=True)
    return tree.RemoveException(place)


_STATEMENTS: Final[Mapping[str, Callable[[Cursor], tree.Statement]]] = {
    "CALL": _call,
    "IF": _if,
    "LOOP": _loop,
    "XEQ_SEQUENCE": _start_sequence,
    "XEQ_TASK": _start_task,
    "CONDITION": _condition,
    "WAIT_TIME": _wait,
    "CASE": _case,
    "EXCEPTION": _exception,
    "EXCEPTION_ENTRY": _exception_entry,
    "REMOVE_EXCEPTION": _remove_exception,
}
