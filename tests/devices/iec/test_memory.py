"""Pointers that see bytes, text constants in generated code, and the limits of memory."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import IecBench, program

from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.mistakes import CompileError

FORMATS = {
    "BOOL": "<?",
    "SINT": "<b",
    "BYTE": "<B",
    "INT": "<h",
    "WORD": "<H",
    "DINT": "<i",
    "UDINT": "<I",
    "REAL": "<f",
    "LREAL": "<d",
    "TIME": "<I",
}
DECLARATIONS = "\n".join(f"v_{kind} : {kind};" for kind in FORMATS)
PACKED = program(
    f"before : DWORD; {DECLARATIONS} after : DWORD; seen : ARRAY[0..31] OF BYTE; i : INT; p : POINTER TO BYTE;"
    f"w : POINTER TO DWORD; place : INT; new, read : DWORD;",
    "p := ADR(v_BOOL); FOR i := 0 TO 30 DO seen[i] := p^; p := p + 1; END_FOR"
    " w := ADR(v_BOOL) + place; read := w^; IF new <> 0 THEN w^ := new; END_IF",
)
BENCH = IecBench(PACKED)


def strategy(kind: str) -> st.SearchStrategy[Value]:
    if kind == "BOOL":
        return st.booleans()
    if kind in ("REAL", "LREAL"):
        return st.floats(width=32 if kind == "REAL" else 64, allow_nan=False)
    bits = 8 * struct.calcsize(FORMATS[kind])
    is_signed = FORMATS[kind][1].islower()
    return st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) if is_signed else st.integers(0, 2**bits - 1)


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(
    values=st.fixed_dictionaries({kind: strategy(kind) for kind in FORMATS}),
    at=st.integers(0, 27),
    new=st.integers(1, 2**32 - 1),
)
def test_pointers_see_the_bytes_of_all_types(values: dict[str, Value], at: int, new: int) -> None:
    for kind, value in values.items():
        BENCH[f"v_{kind}"] = value
    BENCH["place"], BENCH["new"] = at, 0
    BENCH.cycle()
    expected = b"".join(struct.pack(FORMATS[kind], values[kind]) for kind in FORMATS)
    assert bytes(int(BENCH[f"seen[{number}]"]) for number in range(31)) == expected
    assert BENCH["read"] == int.from_bytes(expected[at : at + 4], "little")
    BENCH["new"] = new
    BENCH.cycle()
    written = expected[:at] + new.to_bytes(4, "little") + expected[at + 4 :]
    offset = 0
    for kind, form in FORMATS.items():
        part = written[offset : offset + struct.calcsize(form)]
        offset += len(part)
        (value,) = struct.unpack(form, part)
        assert BENCH[f"v_{kind}"] == value or value != value
    assert (BENCH["before"], BENCH["after"]) == (0, 0)


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(text=st.binary(min_size=1, max_size=20))
def test_text_constants_of_any_characters_stay_texts(text: bytes) -> None:
    """Quotes, line ends and braces in a text never become code."""
    literal = "'" + "".join(f"${byte:02X}" for byte in text) + "'"
    bench = IecBench(
        program(
            "s, t : STRING(50); n : INT; same : BOOL;",
            f"s := {literal}; t := CONCAT(s, {literal}); n := FIND(t, {literal}); same := s = {literal};",
        )
    )
    bench.cycle()
    expected = text.decode("latin-1")
    assert (bench["s"], bench["t"], bench["n"], bench["same"]) == (expected, expected * 2, 1, True)


NAMES = [
    "base",
    "frame",
    "pc",
    "n",
    "M",
    "K",
    "F",
    "why",
    "leave",
    "t0",
    "r0",
    "print",
    "None",
    "class",
    "lambda",
    "import",
    "eval",
    "open",
    "exec",
]


@pytest.mark.parametrize("name", NAMES)
def test_names_of_the_generated_code_are_names_like_others(name: str) -> None:
    text = (
        f"FUNCTION_BLOCK Box VAR_INPUT {name} : INT; END_VAR VAR_OUTPUT out : INT; END_VAR "
        f"out := {name} + 1; END_FUNCTION_BLOCK\n"
    )
    body = f"FOR {name} := 1 TO 3 DO box({name} := {name}); sum := sum + box.out + {name}; END_FOR"
    bench = IecBench(text + program(f"{name}, sum : INT; box : Box;", body))
    bench.cycle()
    assert (bench["sum"], bench[name]) == (15, 4)


@pytest.mark.manual("PD-312", "PD-313")
def test_more_variables_than_the_data_area_has_room_for_are_refused() -> None:
    names = ", ".join(f"a{number}" for number in range(20))
    lists = "".join(f"VAR_GLOBAL b{number} : ARRAY[1..30000] OF DWORD; END_VAR " for number in range(16))
    with pytest.raises(CompileError, match="1900544"):
        IecBench(lists + program(f"{names} : INT;", ""))
