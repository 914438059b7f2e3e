"""Texts that end too early: every listing of the manual, and every kind of declaration, cut behind each of its tokens.

A parser, the checker, the formatter and the parser of the debugger answer each of them with messages.
"""

from contextlib import suppress
from pathlib import Path

import pytest
from pam_listings import LISTINGS, WHOLE
from pam_programs import HEADER, in_sequence

from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.formatter import formatted
from fieldrig_devices.pam.language.objects import KINDS, SPECS
from fieldrig_devices.pam.language.preprocessor import Preprocessor
from fieldrig_devices.pam.language.reserved import ITEMS
from fieldrig_devices.pam.language.tokens import split
from fieldrig_devices.pam.language.words import STRUCTURE
from fieldrig_devices.pam.runtime.compiler import compile_application
from fieldrig_devices.pam.runtime.memory_objects import MemoryObjects
from fieldrig_devices.pam.runtime.runtime import Runtime

SHIPPED = Path(__file__).parents[4] / "configs" / "programs" / "labeller.pam"


def cuts(text: str) -> list[str]:
    """The beginnings of a text up to each of its tokens, and up to the middle of each."""
    starts = [0]
    for line in text.split("\n"):
        starts.append(starts[-1] + len(line) + 1)
    found = []
    for token in split(text, "").tokens[:-1]:
        at = starts[token.place.line - 1] + token.place.column - 1
        found += [text[:at], text[: at + (len(token.text) + 1) // 2]]
    return found


def read(text: str) -> None:
    """Compile and format a text; whatever is wrong with it is a message with a place that it has."""
    _, mistakes = checked(text, "cut.pam")
    lines = text.count("\n") + 1
    assert all(1 <= mistake.line <= lines and mistake.column >= 1 and mistake.what for mistake in mistakes)
    assert formatted(formatted(text)) == formatted(text)


@pytest.mark.long
@pytest.mark.parametrize("number", sorted({*LISTINGS, *WHOLE}))
def test_listings_that_end_early_have_messages(number: int) -> None:
    for text in cuts(LISTINGS.get(number) or WHOLE[number]):
        read(text)


@pytest.mark.long
def test_a_shipped_application_that_ends_early_has_messages() -> None:
    for text in cuts(SHIPPED.read_text())[::67]:
        read(text)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if " " not in kind])
def test_every_parameter_of_every_kind_may_be_the_last_word(kind: str) -> None:
    for name in KINDS[kind]:
        for end in (
            "",
            " ",
            " =",
            " = ;",
            " = -",
            " = 1",
            " = 1.",
            " = A",
            " = A[",
            " = A SUBSET",
            " = #1 BIT",
            " BINARY_INPUT",
        ):
            read(f"{HEADER}{kind} X; {name}{end}")


@pytest.mark.parametrize("kind", SPECS)
def test_every_parameter_of_every_header_may_be_the_last_word(kind: str) -> None:
    header = {"APPLICATION": "APPLICATION NAME = a V1.00; ", "SEQUENCE": "TASK T; SEQUENCE S; SPECS "}
    for name in SPECS[kind]:
        for end in ("", " ", " =", " = ;", " = 1", " = 1;"):
            read(f"{header.get(kind, f'{kind} X; SPECS ')}{name}{end}")


@pytest.mark.long
@pytest.mark.parametrize(
    "before",
    [
        "RS422 PORT SPECS {} END_SPECS {} INPUT FLAG_VAR F; {} END_PORT",
        "VME DUALPORT SPECS {} END_SPECS {} INPUT FLAG_VAR F; {} END_DUALPORT",
        "DUAL_PORT {} END {}",
        "TASK T; SPECS {} END_SPECS EVENTS {} END_EVENTS {} SEQUENCE S; {} END_SEQUENCE {} END_TASK",
        "ACTIONS A; SPECS {} END_SPECS {} ON_EVENT F ACTION {} END_ACTION END_ACTIONS",
        "ROUTINES R; {} ROUTINE Q; {} END_ROUTINE {} END_ROUTINES",
    ],
)
def test_any_word_of_the_language_may_be_anywhere(before: str) -> None:
    """The parser of a port once did not end at NODE with a semicolon."""
    parts = before.split("{}")
    for number in range(1, len(parts)):
        for word in (*ITEMS, *STRUCTURE):
            for behind in ("", ";", " =", " = 1;"):
                read(f"{HEADER}{''.join(parts[:number])}{word}{behind}{''.join(parts[number:])}")


@pytest.mark.parametrize("wrong", ["CWV_Count 1;", "CWV_Count <- 1 + ;", "CWV_Count <- (1;", "IF THEN END_IF", "@"])
def test_wrong_statements_are_no_levels(wrong: str) -> None:
    """A sequence with 60 mistakes once had a wrong message at each statement behind them."""
    _, found = checked(in_sequence(f"{wrong}\n" * 90 + "CWV_Count <- ((1));"), "a.pam")
    assert found
    assert not any("nested" in mistake.expected for mistake in found)


@pytest.mark.parametrize(
    "text",
    [
        "#include",
        '#include "',
        '#include "a',
        "#define",
        "#define A",
        "#set",
        "#set A",
        "#set A B |",
        "#undef",
        "# ",
        "#\\\n",
    ],
)
def test_directives_that_end_early_have_messages(text: str) -> None:
    read(HEADER + text)
    Preprocessor().file(split(text, ""))


@pytest.mark.long
def test_watch_expressions_that_end_early_have_messages() -> None:
    program = compile_application(in_sequence("CRV_Size <- 1;"), "a.pam")
    runtime = Runtime(program)
    runtime.start(MemoryObjects(program, runtime))
    whole = '!(IFV_Up + (CRV_Size ^ -2 ? sin <= 4.5) * (IFV_Each[i])[all+]) + IFV_Up % CRV_Size:X(1, "a")'
    for end in range(len(whole) + 1):
        with suppress(ValueError):
            runtime.watch.value(whole[:end])


def test_the_cuts_are_those_of_the_text() -> None:
    assert cuts("ab <- 12;") == ["", "a", "ab ", "ab <", "ab <- ", "ab <- 1", "ab <- 12", "ab <- 12;"]
