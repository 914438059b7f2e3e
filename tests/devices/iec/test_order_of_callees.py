"""The order in which a compilation looks at POUs is that of the text, and the same in every process."""

from iec_program import IecBench, program

NAMES = ("Six", "One", "Five", "Two", "Four", "Three")


def test_callees_are_in_front_of_their_caller_in_an_order_that_the_text_gives() -> None:
    functions = "".join(f"FUNCTION {name} : INT {name} := 1; END_FUNCTION\n" for name in NAMES)
    calls = "".join(f"x := {name}();\n" for name in NAMES)
    lowered = IecBench(program("x : INT;", calls) + functions).compiled.code
    own = [pou.name for pou in lowered.callees_first if pou.name in (*NAMES, "PLC_PRG")]
    assert own == [*reversed(NAMES), "PLC_PRG"]
