"""A line that is written as in another language has one message, which names the right form."""

import pytest

from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.languages.mistakes import CompileError

HABITS = [
    ("V1 := 5", "got :=; expected =="),
    ("V1 <- 5", "got <-; expected =="),
    ("V[2] =: 5", "got =:; expected =="),
    ("V1 ← 5", "got ←; expected =="),
    ("LET V1 == 5", "got LET; expected the assignment alone"),
    ("V1++", "got ++; expected V1 += 1"),
    ("V1--", "got --; expected V1 -= 1"),
    ("++V1", "got ++; expected V1 += 1"),
    ("V1 == V2++", "got ++; expected V2 += 1"),
    ("REM a remark", "got REM; expected a comment, which begins with ;"),
    ("// a remark", "got //; expected a comment"),
    ("(* a remark *)", "got (*; expected a comment"),
    ("' a remark", "got '; expected a comment"),
    ("{ a remark }", "got {; expected a comment"),
    ("GOSUB L", "got GOSUB; expected CALL"),
    ("DELAY 5", "got DELAY; expected WAIT"),
    ("WAIT 5s", "got 5s; expected 5, a time without its unit"),
    ("ENDIF", "got ENDIF; expected another way: an IF is one line"),
    ("END_IF", "got END_IF; expected another way: an IF is one line"),
    ("ELSE", "got ELSE; expected another way: an IF is one line"),
    ("FOR V1 = 1 TO 5", "got FOR; expected a label, and IF V1 < 5, LABEL"),
    ("WHILE V1 < 5", "got WHILE; expected a label"),
    ("NEXT", "got NEXT; expected a label"),
    ("RETURN", "got RETURN; expected GOTO: a routine ends at its END"),
    ("IF V1 = 5 THEN GOTO L", "got THEN; expected a comma"),
    ("IF V1 = 5 AND V2 = 3, L", "got AND; expected one comparison, and another IF behind the comma"),
    ("IF (V1 = 5), L", "got (V1 = 5); expected the comparison without parentheses"),
    ("IF F1, L", "got F1; expected F1 <> LO"),
    ("IF NOT F1, L", "got NOT F1; expected F1 = LO"),
    ("IF /F1, L", "got /F1; expected F1 = LO"),
    ("IF V1 != 5, L", "got !=; expected <>"),
    ("IF V1 => 5, L", "got =>; expected >="),
    ("IF F1 = TRUE, L", "did you mean HI?; expected HI"),
    ("F1 == LOW", "did you mean LO?; expected LO"),
    ("V1 == 0x1F", "got 0x1F; expected H1F"),
    ("V1 == $1F", "got $1F; expected H1F"),
    ("V1 == 16#1F", "got 16#1F; expected H1F"),
    ("V1 == &HFF", "got &HFF; expected HFF"),
    ("V1 == 1FH", "got 1FH; expected H1F"),
    ("V1 == 2#101", "got 2#101; expected 5"),
    ("V1 == 1e3", "got 1e3; expected a number without an exponent"),
    ("V1 == 1,5", "got 1,5; expected 1.5"),
    ("MSG 1, 'hello'", "got 'hello'; expected \"hello\""),
    ("V1 == SIN(V2)", "got SIN; expected SEN"),
    ("V1 == SQRT(V2)", "got SQRT; expected SQR"),
    ("V(1) == 5", "got V(1); expected V[1]"),
    ("V1 == V2 MOD 2", "got MOD; expected %"),
    ("V1 == V2 AND H0F", "got AND; expected &"),
    ("V1 == V2 – 1", "got –; expected -"),
    ("SET F1 = 1", "got SET F1 = 1; expected SET F1"),
]


@pytest.mark.parametrize(("line", "said"), HABITS)
def test_a_habit_has_one_message_with_the_right_form(line: str, said: str) -> None:
    with pytest.raises(CompileError) as caught:
        compile_text(f"BEG MAIN\nL:\n  {line}\n  GOTO L\nEND\n")
    (found,) = (mistake for mistake in caught.value.mistakes if not mistake.is_note)
    assert said in str(found)
    assert found.line == 3


@pytest.mark.parametrize("line", ["V1 == #NO", "V1 == 5 + ; IF V1 => 5", "PAC 1 ; SIN"])
def test_another_mistake_keeps_its_message(line: str) -> None:
    """A comment, or a place in front of the mistake, is no habit."""
    with pytest.raises(CompileError) as caught:
        compile_text(f"BEG MAIN\n  {line}\nEND\n")
    assert "got " not in str(caught.value)
