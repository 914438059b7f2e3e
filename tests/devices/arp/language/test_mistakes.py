"""Messages of the compiler about wrong programs: where, what is wrong, and what was expected."""

import pytest

from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.languages.mistakes import CompileError, Mistake


def mistakes(source: str) -> list[Mistake]:
    try:
        return list(compile_text(source).notes)
    except CompileError as wrong:
        return wrong.mistakes


def of_line(line: str) -> list[Mistake]:
    """Mistakes in one line of a program with a subprogram SUB and an interrupt routine IRQ."""
    source = f"BEG MAIN\n{line}\nEND\nBEG SUB\nHERE:\nEND\nBEGA IRQ\nENDA"
    found = mistakes(source)
    assert all(mistake.line == 2 for mistake in found), found
    return found


SYNTAX = [
    # line, column, part of the message, part of what was expected
    ("V1 = 5", 4, "=", "=="),
    ("V1 == ", 6, "end of the line", "a number"),
    ("V1 == 5 +", 10, "end of the line", "a number"),
    ("V1 == (5 + V2", 14, ")", ")"),
    ("V1 == 5 V2 == 6", 9, "not expected here", "one instruction per line"),
    ("V1 == 5.", 7, "5.", "one to three digits"),
    ("V1 == 0.0001", 7, "0.0001", "one to three digits"),
    ("V1 == 1000000", 7, "too large", "999999.999"),
    ("V1 == H123456789", 7, "9 digits", "8"),
    ("V1 == SQR V2", 11, "SQR", "("),
    ("V1 == QUOTA[1]", 12, "[", "one instruction per line"),
    ("QUOTA[1] == 2", 6, "[", "=="),
    ("V1 == @POS 1", 7, "no number", "without a blank"),
    ("V1 == @SPEED1", 7, "@SPEED1", "@POS"),
    ("V1 == @PAR1", 12, "[", "number of the parameter"),
    ("V[1.5] == 1", 3, "1.5", "digits"),
    ("V[F1] == 1", 3, "F1", "variable V"),
    ("IF VI > 100 L01", 13, ",", "a comma"),
    ("IF V1 == 5, SET F1", 7, "==", "=, <>"),
    ("IF V1 > 5,", 11, "end of the line", "an instruction"),
    ("GOTO", 5, "end of the line", "a label"),
    ("GOTO END", 6, "END", "a label"),
    ("CALL 5", 6, "5", "a subprogram"),
    ("ON F1 & F2 IRQ", 1, "no number", "ON1 to ON6"),
    ("ON7 F1 & F2 IRQ", 1, "ON7", "ON1 to ON6"),
    ("ON1 F1 F2 IRQ", 8, "&", "&"),
    ("ON1 F1 & (F2 IRQ", 14, ")", ")"),
    ("CAM0", 1, "CAM0", "CAM1 to CAM6"),
    ("CAM1 1, 2, 3", 13, "too early", "0 or 4 values"),
    ("PAC 1", 6, "too early", "an axis, 1 or 2; a number"),
    ("STOP 1, 2", 9, "not expected here", "STOP with 1"),
    ("TERM 1, 2, 3", 13, "too early", "0 or 2 or 4 or 5 or 6"),
    ("TERM 1, 2, 1, 4, V1, X", 22, "X", "E or P"),
    ("MSG 1, HELLO", 8, "HELLO", "a string"),
    ('MSG 1, "HELLO', 8, "no end", "quote"),
    ("SPEED 5", 7, "after SPEED", "=="),
    ("GOT L1", 5, "did you mean GOTO", "=="),
    ("5 == V1", 1, "5", "an instruction"),
    ("PIG == 3", 1, "PIG", "an instruction"),
    ("V1 == §", 7, "§", "printable ASCII"),
    ("ERROR == V1", 1, "ERROR", "an instruction"),
    ("V1: SET F1", 1, "V1", "a label"),
    ("STOP EQU V1", 1, "STOP", "a name"),
]


@pytest.mark.parametrize(("line", "column", "what", "expected"), SYNTAX)
def test_a_line_that_can_not_be_read(line: str, column: int, what: str, expected: str) -> None:
    (found,) = of_line(line)
    assert found.column == column
    assert what in found.what
    assert expected in found.expected
    assert not found.is_note


MEANING = [
    ("VI == 5", 1, "VI is not defined; did you mean V1?", "VI EQU, or V1"),
    ("V1 == QUOTA", 7, "QUOTA is not defined", "QUOTA EQU"),
    ("V == 1", 1, "V is not defined", "V EQU"),
    ("V1 == HERE", 7, "a label", "a variable"),
    ("V1 == SUB", 7, "a routine", "CALL"),
    ("V1001 == 1", 1, "no V1001", "V1 to V1000"),
    ("V0 == 1", 1, "no V0", "V1 to V1000"),
    ("SET F1112", 5, "no F1112", "F1 to F320"),
    ("V1 == I133", 7, "no I133", "I101 to I132 or I201"),
    ("V1 == V[V1001]", 9, "no V1001", "V1 to V1000"),
    ("V1 == @POS3", 7, "no @POS3", "1 to 2"),
    ("V1 == @FLAG11", 7, "no @FLAG11", "1 to 10"),
    ("V1 == @PAR[17]", 7, "no parameter 17", "1 to 16"),
    ("V1 == @PAR3[1]", 7, "no axis 3", "@PAR1"),
    ("V1 == @PAR2[26]", 7, "no parameter 26", "1 to 25"),
    ("@PAR[1] == 2", 1, "general parameters", "@PAR1"),
    ("#VEL1 == 2", 1, "only be read", "@"),
    ("I101 == HI", 1, "an input", "an output"),
    ("SET I101", 5, "not allowed here", "a flag F or an output O"),
    ("SET F260", 5, "only the system writes F260", "R/W"),
    ("F305 == LO", 1, "only the system writes F305", "R/W"),
    ("F1 == V1", 7, "one bit", "flags, inputs"),
    ("F1 == F2 & V1", 10, "one bit", "flags, inputs"),
    ("F1 == 5 | F2", 9, "one bit", "flags, inputs"),
    ("F1 += 1", 1, "one bit", "=="),
    ("F1 == ADC 1", 7, "one bit", "a variable V"),
    ("V1 == ADC 7", 11, "7 is not allowed here", "ADC with 1 to 6"),
    ("V1 == TIM V2", 11, "only a constant", "TIM with 1 to 6"),
    ("IF 5 > 4, SET F1", 4, "two constants", "a variable"),
    ("IF HI = LO, SET F1", 4, "two constants", "a variable"),
    ("GOTO THERE", 1, "no label THERE", "THERE:"),
    ("GOTO HERE", 1, "is in SUB", "same routine"),
    ("GOTO SUB", 1, "a routine", "CALL SUB"),
    ("IF F1 = HI, THERE", 13, "no label THERE", "THERE:"),
    ("CALL THERE", 1, "no subprogram THERE", "BEG THERE"),
    ("CALL IRQ", 1, "interrupt routine", "BEG"),
    ("CALL MAIN", 1, "main program", "a subprogram"),
    ("ON1 F1 & F2 SUB", 1, "no interrupt routine", "BEGA"),
    ("ON1 F1 & F2 THERE", 1, "no interrupt routine THERE", "BEGA THERE"),
    ("ON1 I101 & F2 IRQ", 5, "not allowed here", "a flag"),
    ("ON1 F1 & O101 IRQ", 10, "not allowed here", "a flag or an input"),
    ("ON1 F1 & 3 > V1 IRQ", 10, "3 is not allowed here", "an axis"),
    ("ON1 F1 & 1 > F1 IRQ", 14, "not allowed here", "a variable V"),
    ("PAC 3, 100", 5, "3 is not allowed here", "an axis"),
    ("PAC V1, 100", 5, "only a constant", "an axis"),
    ("PST 2, 1, 10", 11, "not allowed here", "a variable V"),
    ("DAC 3, 1", 5, "3 is not allowed here", "an analog output"),
    ("STIM 7", 6, "7 is not allowed here", "a timer"),
    ("STIM 1, 1, O101", 12, "not allowed here", "a flag F"),
    ("CAM1 1, 2, 3, !I101", 16, "not allowed here", "a flag F or an output O"),
    ("MSG 501, \"A\"", 5, "501 is not allowed here", "1 to 500"),
    ("TERM 1, 1, 4, 1", 12, "4 is not allowed here", "a height"),
    ("TERM 2, V100", 9, "only a constant", "a column"),
    ("PRINT 501", 7, "501 is not allowed here", "0 to 500"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "column", "what", "expected"), MEANING)
def test_a_line_that_makes_no_sense(line: str, column: int, what: str, expected: str) -> None:
    (found,) = of_line(line)
    assert found.column == column
    assert what in found.what
    assert expected in found.expected
    assert not found.is_note


NOTES = [
    ('MSG 2, "LENGTH: = #####.#"', 8, "17 characters"),
    ("TERM 2, 22, 3, 2, V100", 9, "22 is off the screen"),
    ("V1 == @ PAR[3]", 7, "no blank"),
]


@pytest.mark.parametrize(("line", "column", "what"), NOTES)
def test_what_is_worth_a_note_compiles(line: str, column: int, what: str) -> None:
    (found,) = of_line(line)
    assert found.is_note
    assert found.column == column
    assert what in found.what


ROUTINES = [
    ("", 1, "no main program"),
    ("; nothing\n", 1, "no main program"),
    ("BEG MAIN\nV1 == 1", 1, "MAIN has no end"),
    ("BEG MAIN\nBEG SUB\nEND", 2, "MAIN, which begins in line 1, has no end"),
    ("BEG MAIN\nENDA", 2, "ENDA cannot end MAIN"),
    ("BEG MAIN\nEND\nEND", 3, "END ends nothing"),
    ("BEG MAIN\nEND\nBEGA IRQ\nEND", 4, "END cannot end IRQ"),
    ("BEGA IRQ\nENDA", 1, "the first routine is the main program"),
    ("V1 == 1\nBEG MAIN\nEND", 1, "outside of every routine"),
    ("BEG MAIN\nEND\nV1 == 1", 3, "outside of every routine"),
    ("BEG MAIN\nEND\nBEG MAIN\nEND", 3, "already defined in line 1"),
]


@pytest.mark.manual("ARP-077")
@pytest.mark.parametrize(("source", "line", "what"), ROUTINES)
def test_a_program_is_a_main_routine_and_others_each_with_its_own_end(source: str, line: int, what: str) -> None:
    (found,) = mistakes(source)
    assert (found.line, found.column, found.is_note) == (line, 1, False)
    assert what in found.what


LABELS = [
    ("BEG MAIN\nL1:\nL1:\nEND", 3, "already defined in line 2"),
    ("BEG MAIN\nL1:\nEND\nBEG SUB\nL1:\nEND", 5, "already defined in line 2"),
    ("BEG MAIN\nL1:\nEND\nBEGA IRQ\nl1:\nENDA", 5, "already defined in line 2"),
    ("BEG MAIN\nMAIN:\nEND", 2, "already defined in line 1"),
    ("L1 EQU V1\nBEG MAIN\nL1:\nEND", 3, "already defined in line 1"),
]


@pytest.mark.manual("ARP-076")
@pytest.mark.parametrize(("source", "line", "what"), LABELS)
def test_a_label_is_the_only_one_of_its_name_in_the_whole_source(source: str, line: int, what: str) -> None:
    (found,) = mistakes(source)
    assert (found.line, found.column, found.is_note) == (line, 1, False)
    assert what in found.what


@pytest.mark.manual("ARP-076")
def test_only_a_colon_makes_a_name_a_label() -> None:
    assert mistakes("BEG MAIN\nL1:\nGOTO L1\nL2 : GOTO L2\nEND") == []
    assert [mistake.line for mistake in mistakes("BEG MAIN\nL1\nEND")] == [2]
    assert [mistake.line for mistake in mistakes("BEG MAIN\nGOTO L1:\nEND")] == [2]


WHOLE = [
    ("A EQU V1\nA EQU V2\nBEG MAIN\nEND", 2, "already defined in line 1"),
    ("A EQU B\nB EQU A\nBEG MAIN\nEND", 1, "A is B is A: the definition is circular"),
    ("A EQU F1112\nBEG MAIN\nSET A\nEND", 3, "no F1112"),
    ("A EQU F1112\nBEG MAIN\nEND", 1, "no F1112"),
    ("BEG MAIN\nA EQU @PAR1[26]\nEND", 2, "no parameter 26"),
    ("BEG STOP\nEND", 1, "STOP is a word of the language"),
    ("BEG MAIN ; " + "x" * 120 + "\nEND", 1, "131 characters"),
    ("BEG MAIN\nIF V1 = 1, END\nEND", 2, "END cannot begin an instruction"),
]


@pytest.mark.parametrize(("source", "line", "what"), WHOLE)
def test_a_program_that_does_not_hang_together(source: str, line: int, what: str) -> None:
    assert any(mistake.line == line and what in mistake.what and not mistake.is_note for mistake in mistakes(source))


def test_a_name_may_stand_for_another_name() -> None:
    found = mistakes("A EQU B\nB EQU C\nC EQU V1\nBEG MAIN\nA == 1\nEND")
    assert [mistake.what for mistake in found if not mistake.is_note] == []


@pytest.mark.manual("ARP-075")
@pytest.mark.parametrize(
    ("line", "column", "what"),
    [
        ("V1 == 1 V2 == 2", 9, "not expected here"),  # one instruction per line
        ("V1 == 1 +", 10, "end of the line"),  # no continuation
        ("V1 == 1\u00b5", 8, "has no meaning here"),  # not ASCII
        ("V1 == 1 \x07", 9, "has no meaning here"),  # not printable
    ],
)
def test_a_line_is_one_instruction_in_printable_ascii(line: str, column: int, what: str) -> None:
    assert of_line("V1 == 1 ; V2 == 2 +") == []
    (found,) = of_line(line)
    assert found.column == column
    assert what in found.what


@pytest.mark.manual("ARP-075")
def test_a_line_has_120_characters_with_its_comment() -> None:
    exact = "V1 == 1 ;" + "x" * 111
    assert of_line(exact) == []
    (found,) = of_line(exact + "x")
    assert (found.column, found.what) == (121, "the line has 121 characters")


def test_everything_wrong_is_said_in_one_go_and_in_order() -> None:
    source = "BEG MAIN\nV1 = 5\nGOTO L2\nV1001 == F400\nX: SET\nEND\nEND"
    found = [(mistake.line, mistake.column) for mistake in mistakes(source)]
    assert found == [(2, 4), (3, 1), (4, 1), (4, 10), (5, 7), (7, 1)]


def test_a_mistake_reads_as_place_fault_and_remedy() -> None:
    (found,) = of_line("V1 = 5")
    assert str(found) == "2:4: values are assigned by ==, and = compares; expected =="


@pytest.mark.parametrize("line", ["X: V1 = 5", "x : V1 == 5 ?", f"X: V1 == {'1 + ' * 40}1"])
def test_a_label_counts_although_its_line_has_another_mistake(line: str) -> None:
    first, second = mistakes(f"BEG M\n{line}\nGOTO X\nX:\nEND")
    assert first.line == 2
    assert (second.line, second.column, second.what) == (4, 1, "X is already defined in line 2")


def test_a_bit_that_does_not_exist_is_one_mistake() -> None:
    assert [mistake.what for mistake in of_line("RES F0")] == ["there is no F0"]
    assert [mistake.what for mistake in of_line("F0 == HI")] == ["there is no F0"]


@pytest.mark.manual("ARP-017")
def test_general_parameters_can_be_read_but_not_written() -> None:
    assert of_line("V1 == @PAR[16]") == []
    (found,) = of_line("@PAR[16] += 1")
    assert (found.column, found.expected) == (1, "@PAR1[...] or @PAR2[...]")
    assert "manual 2.2" in found.what


@pytest.mark.manual("ARP-054")
def test_the_number_of_a_system_variable_is_a_digit_that_touches_it() -> None:
    assert mistakes("AX EQU 1\nBEG MAIN\nV1 == @POSAX\nEND")[0].what == "there is no @POSAX"


@pytest.mark.manual("ARP-084")
def test_calls_nested_eleven_deep_are_refused() -> None:
    chain = "".join(f"BEG S{n}\nCALL S{n + 1}\nEND\n" for n in range(1, 11))
    assert mistakes(f"BEG M\nCALL S2\nEND\n{chain}BEG S11\nEND") == []
    (found,) = mistakes(f"BEG M\nCALL S1\nEND\n{chain}BEG S11\nEND")
    assert (found.line, found.what, found.expected) == (1, "calls are nested 11 deep from M", "at most 10")


@pytest.mark.manual("ARP-084")
def test_recursion_is_worth_a_note() -> None:
    (found,) = mistakes("BEG M\nCALL A\nEND\nBEG A\nIF F1 = HI, CALL A\nEND")
    assert (found.line, found.column, found.is_note) == (4, 1, True)


def test_a_word_that_is_a_name_is_no_hexadecimal_number() -> None:
    assert mistakes("BEG M\nV1 == HEAD\nEND") == []
    assert mistakes("HEAD EQU V5\nBEG M\nV1 == HEAD\nEND") == []
    assert "a label" in mistakes("BEG M\nHEAD:\nV1 == HEAD\nEND")[0].what


def test_a_comment_may_hold_anything() -> None:
    assert of_line('V1 == 1 ; "§ BEG END HEAD: ×') == []


@pytest.mark.manual("ARP-083")
def test_goto_stays_in_its_routine() -> None:
    assert mistakes("BEG M\nL1:\nGOTO L1\nEND") == []
    assert "is in M" in mistakes("BEG M\nL1:\nEND\nBEG S\nGOTO L1\nEND")[0].what
