"""__NEW and __DELETE, with FB_init and FB_exit (the public descriptions of CODESYS V3 and TwinCAT 3)."""

from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS, EDITION_3
from fieldrig_devices.iec.memory import MOST_ALLOCATED
from fieldrig_devices.iec.runtime import Start

BLOCKS = """
VAR_GLOBAL exits : DINT; END_VAR
FUNCTION_BLOCK Base
VAR k : INT := 4; s : INT; END_VAR
METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; n : INT; END_VAR s := n; END_METHOD
METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR exits := exits * 10 + 1; END_METHOD
METHOD Get : INT Get := k + s; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Base
METHOD Get : INT Get := SUPER^.Get() + 1000; END_METHOD
METHOD FB_exit : BOOL VAR_INPUT bInCopyCode : BOOL; END_VAR exits := exits * 10 + 2; END_METHOD
END_FUNCTION_BLOCK
"""


def ran(declarations: str, body: str) -> IecBench:
    bench = IecBench(BLOCKS + program(declarations, body), CODESYS)
    bench.cycle()
    return bench


def test_an_instance_is_started_and_its_methods_are_those_of_its_own_block() -> None:
    bench = ran(
        "p : POINTER TO Base; q : POINTER TO Derived; x, y : INT;",
        "p := __NEW(Base(7)); x := p^.Get(); q := __NEW(Derived(n := 8)); p := q; y := p^.Get();",
    )
    assert (bench["x"], bench["y"]) == (11, 1012)


def test_delete_calls_fb_exit_from_the_block_up_and_clears_the_pointer() -> None:
    bench = ran(
        "p : POINTER TO Base; q : POINTER TO Derived; n : DWORD;",
        "q := __NEW(Derived(1)); p := q; __DELETE(p); n := p; __DELETE(p);",
    )
    assert (bench["exits"], bench["n"]) == (21, 0)


def test_several_in_a_row_are_started_each() -> None:
    bench = ran(
        "p : POINTER TO Base; i : POINTER TO INT; x, y, z : INT;",
        "p := __NEW(Base(7), 3); x := p[2].Get(); i := __NEW(INT, 4); i[3] := 5; y := i[3]; z := i[0];",
    )
    assert (bench["x"], bench["y"], bench["z"]) == (11, 5, 0)


def test_memory_is_used_again_after_a_while_with_start_values_again() -> None:
    text = "TYPE Pair : STRUCT n : INT := 3; END_STRUCT; END_TYPE\n" + program(
        "p : POINTER TO Pair; first, last : DWORD; x, k : INT;",
        "p := __NEW(Pair); first := p; p^.n := 5; __DELETE(p);"
        "FOR k := 1 TO 20 DO p := __NEW(Pair); IF p = first THEN last := p; x := p^.n; END_IF; __DELETE(p); END_FOR;",
    )
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert bench["first"] == bench["last"] != 0
    assert bench["x"] == 3


def test_there_is_nothing_if_there_is_no_room() -> None:
    bench = ran("p : POINTER TO BYTE; isNone : BOOL;", f"p := __NEW(BYTE, {MOST_ALLOCATED + 1}); isNone := p = 0;")
    assert bench["isNone"] is True


def test_a_new_start_takes_everything_back() -> None:
    bench = ran("p : POINTER TO INT; first : DWORD;", "p := __NEW(INT); IF first = 0 THEN first := p; END_IF;")
    first = bench["first"]
    bench.cycle(3)
    bench.runtime.initialise(Start.COLD)
    bench.cycle()
    assert bench["first"] == first


def test_what_was_just_deleted_can_still_be_read() -> None:
    bench = ran("p, q : POINTER TO Base; x : INT;", "p := __NEW(Base(1)); q := p; __DELETE(p); x := q^.Get();")
    assert bench["x"] == 5


def test_what_is_wrong_is_named() -> None:
    found = refused(
        program("p : POINTER TO INT; i : INT;", "p := __NEW(); p := __NEW(Nothing); __DELETE(i); __DELETE();"), CODESYS
    )
    for message in (
        "__NEW with 0 arguments; expected __NEW(type)",
        "the type Nothing is not declared",
        "i is an INT; expected a pointer that __NEW has given",
        "__DELETE with 0 arguments",
    ):
        assert any(message in one for one in found), message


def test_the_standard_has_none() -> None:
    assert any("__NEW" in one for one in refused(program("p : REF_TO INT;", "p := __NEW(INT);"), EDITION_3))


def test_bytes_fill_whole_blocks() -> None:
    """A text of two characters of which the program has asked for three bytes ends with the zero that follows."""
    variables = 'p : POINTER TO WSTRING; s : WSTRING := "0"; t : WSTRING; n : UDINT; is_same : BOOL;'
    text = program(variables, "p := __NEW(BYTE, 3); n := MEMCPY(p, ADR(s), 3); t := p^; is_same := t = s;")
    bench = IecBench(text, CODESYS)
    bench.cycle()
    assert bench["is_same"] is True
