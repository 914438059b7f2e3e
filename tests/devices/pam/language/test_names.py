"""Names that differ from a word of the language by their case, as old applications have them."""

import pytest
from pam_bench import OBJECTS, PamBench
from pam_programs import HEADER, in_sequence

from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.language.formatter import formatted
from fieldrig_devices.pam.language.parser import parse
from fieldrig_devices.pam.language.reserved import IN_CAPITALS, RESERVED


def other_case(word: str) -> str:
    """The word in a case that is neither that of the manual nor all small."""
    return word.title() if word.title() != word else word[:-1].upper() + word[-1].lower()


WORDS = sorted({other_case(word) for word in IN_CAPITALS} - RESERVED)
USES = """{kind} {name};
TASK TSK_a; SPECS CYCLES = 1; END_SPECS
EVENTS ON_EVENT SBI_a * ({name} = 0) XEQ_SEQUENCE SEQ_a; END_EVENTS
SEQUENCE SEQ_a;
  {name} <- 1;
  n <- n + {name} * 2 - ({name});
  IF {name} = 1 THEN {name} <- {name}; ELSE {name} <- 2; END_IF
  LOOP {name} <- {name} + 1; END_LOOP {name} >= 5;
  CONDITION {name} = 5 TIMEOUT 10 + {name};
  WAIT_TIME {name};
  n <- {name};
END_SEQUENCE
END_TASK
"""


def test_most_words_have_another_case() -> None:
    assert len(WORDS) > 200
    assert {"On", "End", "Loop", "Speed", "Value", "Max", "Input", "Address", "Run", "Ready", "Timeout"} <= set(WORDS)


@pytest.mark.parametrize("word", WORDS)
def test_a_variable_may_be_called_so(word: str) -> None:
    text = OBJECTS + USES.format(kind="INTERNAL WORD_VAR", name=word)
    assert [str(wrong) for wrong in checked(text, "x")[1]] == []
    assert parse(formatted(text), "x")[0] == parse(text, "x")[0]


@pytest.mark.parametrize(
    "word", ["On", "End", "Loop", "If", "Else", "Speed", "Wait_Time", "Run", "Node", "Timeout", "end_task"]
)
def test_such_a_variable_has_its_values(word: str) -> None:
    bench = PamBench(USES.format(kind="INTERNAL WORD_VAR", name=word))
    bench.run()
    bench["SBI_a"] = True
    bench.run(2)
    assert (bench["n"], bench[word], bench.errors) == (1, 5, [])
    bench.run(10)
    assert (bench["n"], bench[word]) == (5, 5)


@pytest.mark.parametrize("word", ["On", "End", "Loop", "Task", "Sequence", "Wait", "Position", "End_Sequence"])
def test_programs_may_be_called_so(word: str) -> None:
    text = f"""{HEADER}INTERNAL FLAG_VAR IFV_Go;
ROUTINES Rgr; ROUTINE {word} WITH Value, Max; IF Value = Max THEN IFV_Go <- set; END_IF END_ROUTINE END_ROUTINES
TASK Tsk; SPECS CYCLES = 1; END_SPECS
EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE {word}; END_EVENTS
SEQUENCE First; XEQ_SEQUENCE {word}; END_SEQUENCE
SEQUENCE {word}; CALL {word} WITH 1, 2; EXCEPTION IFV_Go ENTRY {word}; EXCEPTION_ENTRY {word}; END_SEQUENCE
END_TASK
"""
    assert [str(wrong) for wrong in checked(text, "x")[1]] == []


def test_values_of_parameters_are_words_beside_such_names() -> None:
    text = (
        in_sequence("")
        .replace("INTERNAL FLAG_VAR IFV_Go;", "INTERNAL FLAG_VAR IFV_Go; COMMON REAL_VAR High;")
        .replace("ACTIVE = HIGH", "Active = High")
    )
    assert [str(wrong) for wrong in checked(text, "x")[1]] == []


@pytest.mark.manual("PAMS-102")
@pytest.mark.parametrize("word", ["ON", "END", "LOOP", "SPEED", "set", "run"])
def test_the_spelling_of_the_manual_is_no_name(word: str) -> None:
    assert "reserved word" in "\n".join(map(str, checked(f"{HEADER}INTERNAL FLAG_VAR {word};\n", "x")[1]))


def test_names_that_are_the_same_in_any_case_are_no_words() -> None:
    found = checked(f"{HEADER}INTERNAL FLAG_VAR On;\n", "x", ignores_case=True)[1]
    assert "On is a reserved word" in str(found[0])


@pytest.mark.parametrize(
    "text",
    [
        "INTERNAL WORD_VAR W; NODES_GROUP NG; NUMBER = 2; END",
        "INTERNAL WORD_VAR W; END NODES_GROUP NG; NUMBER = 2; END",
        "COMMON FLAG_VAR W;\nNODES_GROUP NG;\nNUMBER = 2;\nEND\nINTERNAL WORD_VAR V; NODES_GROUP = NG; END",
        "INTERNAL WORD_VAR W; NODE N; ADDRESS = 7; TYPE = ST1; END",
    ],
)
def test_a_variable_without_parameters_ends_at_its_semicolon(text: str) -> None:
    assert [str(wrong) for wrong in checked(HEADER + text, "x")[1]] == []
