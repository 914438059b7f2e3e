"""Hash tables of Tc2_Utilities, against a dictionary of Python, and calls of actions with a VAR_IN_OUT."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program, refused

from fieldrig_devices.iec.dialect import CODESYS

PLACES = 5
TABLE = program(
    """
    entries : ARRAY[0..4] OF T_HASHTABLEENTRY; table : T_HHASHTABLE; control : FB_HashTableCtrl;
    data : ARRAY[0..9] OF INT := [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];
    isMade, ok : BOOL; what : INT; key : DWORD; number : INT; p : POINTER TO INT; found : INT; count : UDINT;
    position : POINTER TO T_HASHTABLEENTRY; index : ULINT; all : STRING; isAny : BOOL;
    """,
    """
    IF NOT isMade THEN
        isMade := F_CreateHashTableHnd(ADR(entries), SIZEOF(entries), table);
        control.A_Reset(hTable := table, bOk => ok);
    END_IF
    p := 0; found := -1;
    CASE what OF
    1: control.A_Add(hTable := table, key := key, putValue := ADR(data[number]), getValue => p, bOk => ok);
    2: control.A_Remove(hTable := table, key := key, getValue => p, bOk => ok);
    3: control.A_Lookup(hTable := table, key := key, getValue => p, bOk => ok);
    END_CASE
    IF ok AND p <> 0 THEN found := p^; END_IF
    count := table.nCount;
    all := '';
    control.A_GetFirst(hTable := table, getValue => p, getPosPtr => position, bOk => isAny);
    WHILE isAny DO
        all := CONCAT(all, INT_TO_STRING(p^));
        control.A_GetIndexAtPosPtr(hTable := table, putPosPtr := position, getValue => index);
        IF entries[index].value <> ADR(data[p^]) THEN all := CONCAT(all, '?'); END_IF
        control.A_GetNext(hTable := table, putPosPtr := position, getValue => p, getPosPtr => position, bOk => isAny);
    END_WHILE
    """,
)


@pytest.fixture(scope="module")
def compiled() -> IecBench:
    return IecBench(TABLE, CODESYS)


@settings(max_examples=40, deadline=None)
@given(steps=st.lists(st.tuples(st.integers(1, 3), st.integers(0, 7), st.integers(0, 9)), max_size=25))
def test_a_table_has_what_a_dictionary_has(compiled: IecBench, steps: list[tuple[int, int, int]]) -> None:
    bench, known = compiled, dict[int, int]()
    bench["isMade"] = False
    for what, key, number in steps:
        bench["what"], bench["key"], bench["number"] = what, key, number
        before = dict(known)
        if what == 1 and (key in known or len(known) < PLACES):
            known[key] = number
        elif what == 2:
            known.pop(key, None)
        bench.cycle()
        expected = {1: known.get(key), 2: before.get(key), 3: known.get(key)}[what]
        assert bench["ok"] == (expected is not None)
        assert bench["found"] == (-1 if expected is None else expected)
        assert bench["count"] == len(known)
        assert sorted(str(bench["all"])) == sorted("".join(map(str, known.values())))


ACTION = """
FUNCTION_BLOCK Adder
VAR_INPUT more : INT; END_VAR
VAR_IN_OUT sum : DINT; list : ARRAY[*] OF INT; END_VAR
VAR_OUTPUT most : DINT; END_VAR
ACTION Add:
sum := sum + more + list[1];
most := UPPER_BOUND(list, 1);
END_ACTION
END_FUNCTION_BLOCK
"""


def test_an_action_is_called_with_its_var_in_out() -> None:
    declared = "a : Adder; x, y, m : DINT; two : ARRAY[1..2] OF INT := [10, 0]; six : ARRAY[1..6] OF INT := [20, 5(0)];"
    body = "a.Add(more := 1, sum := x, list := two); a.Add(more := 2, sum := y, list := six, most => m); a.Add();"
    bench = IecBench(ACTION + program(declared, body), CODESYS)
    bench.cycle()
    assert (bench["x"], bench["y"], bench["m"]) == (11, 44, 6)


def test_what_cannot_be_passed_to_an_action_is_refused() -> None:
    body = "a.Add(sum := 5, list := two);"
    found = refused(ACTION + program("a : Adder; two : ARRAY[1..2] OF INT;", body), CODESYS)
    assert any("5 is passed to the VAR_IN_OUT sum" in one for one in found)


def test_a_program_may_have_an_entry_of_its_own() -> None:
    own = "TYPE T_HashTableEntry : STRUCT key : DWORD; value : PVOID; END_STRUCT; END_TYPE\n"
    bench = IecBench(own + TABLE, CODESYS)
    bench["what"], bench["key"], bench["number"] = 1, 6, 4
    bench.cycle()
    assert (bench["ok"], bench["entries[0].key"], bench["count"]) == (True, 6, 1)
