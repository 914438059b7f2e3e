"""METHOD in function blocks and programs (edition 3)."""

import pytest
from iec_check import messages
from iec_program import IecBench

from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit

TANK = """
FUNCTION_BLOCK Tank
VAR_INPUT step : INT := 1; END_VAR
VAR_OUTPUT level : INT; END_VAR
VAR calls : INT; most : INT := 100; END_VAR

METHOD PUBLIC Fill : BOOL
VAR_INPUT amount : INT; twice : BOOL := FALSE; END_VAR
VAR_OUTPUT free : INT; END_VAR
VAR i, level_ : INT; END_VAR
    FOR i := 1 TO SEL(twice, 1, 2) DO
        level := level + amount * step;
    END_FOR;
    Count();
    free := most - level;
    Fill := level > most;
END_METHOD

METHOD PRIVATE Count
    calls := calls + 1;
END_METHOD

METHOD Set
VAR_INPUT level : INT; END_VAR
    THIS^.level := level;
    THIS^.Count();
    THIS^.Log();
END_METHOD

level := level + step;

ACTION Log:
    most := most + 1;
END_ACTION
END_FUNCTION_BLOCK
"""


def bench_of(declarations: str, body: str, before: str = TANK) -> IecBench:
    bench = IecBench(f"{before}\nPROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n", EDITION_3)
    bench.cycle()
    assert bench.thread.fault is None, bench.thread.fault
    return bench


def test_a_method_works_with_its_instance_and_has_variables_of_its_own() -> None:
    bench = bench_of(
        "a, b : Tank; full, over : BOOL; free : INT;",
        """full := a.Fill(30);
        a.Fill(amount := 10, twice := TRUE, free => free);
        over := b.Fill(101) AND NOT a.Fill(1);
        b();
        a.Set(7);""",
    )
    names = ("full", "free", "over", "a.level", "b.level", "a.calls", "b.calls", "a.most", "b.most")
    assert [bench[name] for name in names] == [False, 50, True, 7, 102, 4, 1, 101, 100]


def test_methods_of_elements_references_and_parameters() -> None:
    before = (
        TANK
        + """
    FUNCTION FillAll : INT
    VAR_IN_OUT tank : Tank; END_VAR
    tank.Fill(2);
    FillAll := tank.level;
    END_FUNCTION
    """
    )
    bench = bench_of(
        "tanks : ARRAY[1..3] OF Tank; r : REFERENCE TO Tank; p : POINTER TO Tank; i, n : INT;",
        """FOR i := 1 TO 3 DO
            tanks[i].Fill(i * 10);
        END_FOR;
        r REF= tanks[2];
        r.Fill(1);
        p := ADR(tanks[3]);
        p^.Fill(1);
        n := FillAll(tanks[1]) + SEL(tanks[FillAll(tanks[1]) - 12].Fill(1), 0, 1000);""",
        before,
    )
    assert [bench[f"tanks[{number}].level"] for number in (1, 2, 3)] == [14, 22, 31]
    assert bench["n"] == 12


def test_a_program_has_methods_and_a_method_calls_itself() -> None:
    text = """
    PROGRAM PLC_PRG
    VAR result, depth : DINT; END_VAR
    result := Factorial(5) + THIS^.Factorial(3);
    END_PROGRAM
    METHOD Factorial : DINT
    VAR_INPUT n : DINT; END_VAR
        depth := depth + 1;
        IF n > 1 THEN
            Factorial := n * THIS^.Factorial(n - 1);
        ELSE
            Factorial := 1;
        END_IF;
    END_METHOD
    """
    bench = IecBench(text, EDITION_3)
    bench.cycle()
    assert (bench["result"], bench["depth"]) == (126, 8)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("t.Fill(once := 1);", "Tank.Fill has no input once; amount, twice"),
        ("n := t.Set(1);", "the method Tank.Set has no result; a method with a type, METHOD name : INT"),
        ("t.Empty();", "Tank has no variable Empty; an input or output"),
        ("t.Fill(TRUE);", "TRUE is a BOOL; INT"),
        ("Fill(1);", "Fill is not declared; an instance, program, action or function"),
    ],
)
def test_a_wrong_call_is_refused_once(body: str, message: str) -> None:
    text = f"PROGRAM PLC_PRG VAR t : Tank; n : INT; END_VAR {body} END_PROGRAM"
    found = [message.partition(" ")[2] for message in messages(TANK, text, dialect=EDITION_3)]
    assert found == [message]


@pytest.mark.parametrize(
    "outer",
    [
        "TYPE Result : (Success, Fail); END_TYPE",
        "VAR_GLOBAL Fail : INT; END_VAR",
        "VAR_GLOBAL CONSTANT Fail : INT := 3; END_VAR",
        "VAR_GLOBAL Fail : TON; END_VAR",
        "PROGRAM Fail VAR END_VAR END_PROGRAM",
        "FUNCTION Fail : INT Fail := 9; END_FUNCTION",
        "FUNCTION_BLOCK Fail VAR END_VAR END_FUNCTION_BLOCK",
    ],
)
def test_a_method_hides_what_has_its_name_outside_of_its_block(outer: str) -> None:
    block = """
    FUNCTION_BLOCK Job
    VAR failures : INT; END_VAR
    METHOD Fail : BOOL VAR_INPUT n : INT; END_VAR failures := failures + n; Fail := TRUE; END_METHOD
    METHOD Run VAR is : BOOL; END_VAR Fail(2); is := Fail(n := 5); END_METHOD
    END_FUNCTION_BLOCK
    """
    assert bench_of("j : Job;", "j.Run();", outer + block)["j.failures"] == 7


def test_two_methods_of_one_name_and_a_method_of_a_function_are_refused() -> None:
    parts = "METHOD m END_METHOD ACTION n: END_ACTION METHOD M END_METHOD METHOD n END_METHOD"
    twice = f"FUNCTION_BLOCK f {parts} END_FUNCTION_BLOCK"
    assert [found.partition(" ")[2] for found in messages(twice, dialect=EDITION_3)] == [
        "f has two actions or methods M; another name",
        "f has two actions or methods n; another name",
    ]
    (found,) = messages("FUNCTION f : INT f := 1; METHOD m END_METHOD END_FUNCTION", dialect=EDITION_3)
    assert found.endswith("a method of a function; a method of a function block")


COMMENTED = """\
(* the tank *)
FUNCTION_BLOCK Tank
VAR
    level : INT;
END_VAR

level := 1;

(* fills the tank
   to the top *)
METHOD PUBLIC Fill : BOOL
VAR_INPUT
    amount : INT; (* in litres *)
END_VAR

(* nothing more *)
level := level + amount;
(* the end *)
END_METHOD

(* empties it *)
METHOD Drain
level := 0;
END_METHOD

(* counts *)
ACTION Count:
    level := level + 1;
END_ACTION
END_FUNCTION_BLOCK
"""


def test_comments_stay_in_front_of_their_method() -> None:
    unit, mistakes = parse(COMMENTED, "tank.st", EDITION_3)
    assert mistakes == []
    assert print_unit(unit) == COMMENTED


def test_epas_has_no_methods() -> None:
    assert "a METHOD is not supported" in str(messages_of_epas())


def messages_of_epas() -> list[str]:
    return [mistake.what for mistake in parse(TANK, "tank.st")[1]]


@pytest.mark.parametrize("name", ["mark", "THIS^.mark"])
def test_a_method_does_not_know_the_temporary_variables_of_its_block(name: str) -> None:
    """They exist while the body of the block runs, and are found in no other place."""
    block = f"""
    FUNCTION_BLOCK B
    VAR_TEMP mark : INT; END_VAR
    VAR n : INT; END_VAR
    METHOD Note n := {name}; END_METHOD
    mark := 3;
    END_FUNCTION_BLOCK
    PROGRAM PLC_PRG VAR b : B; END_VAR b(); END_PROGRAM
    """
    (message,) = messages(block, dialect=EDITION_3)
    assert "mark" in message


def test_a_method_finds_a_global_variable_behind_a_temporary_one_of_its_block() -> None:
    bench = IecBench(
        """
        VAR_GLOBAL mark : INT := 9; END_VAR
        FUNCTION_BLOCK B
        VAR_TEMP mark : INT; END_VAR
        VAR n, own : INT; END_VAR
        METHOD Note n := mark; END_METHOD
        mark := 3;
        Note();
        own := mark;
        END_FUNCTION_BLOCK
        PROGRAM PLC_PRG VAR b : B; END_VAR b(); END_PROGRAM
        """,
        EDITION_3,
    )
    bench.cycle()
    assert (bench["b.n"], bench["b.own"]) == (9, 3)
