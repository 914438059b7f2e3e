"""The limits of the MAx-4 (digest 1.16): each message says how much there is and how much may be."""

from dataclasses import replace

import pytest
from iec_check import messages, program

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec import compiler
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.limits import MAX_4
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.limits import limits_of
from fieldrig_devices.max4.configuration.version import Version


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (
            ["(* " + "x" * 60, "x" * 60],
            "2.st:1:1: the sources are too long up to here; expected at most 100",
        ),
        ([";" * 6, ";" * 6], "2.st:1:1: there are too many statements up to here; expected at most 10 together"),
    ],
)
def test_sources_that_are_far_too_large_are_refused_at_once(
    monkeypatch: pytest.MonkeyPatch, texts: list[str], message: str
) -> None:
    monkeypatch.setattr(compiler, "MOST_CHARACTERS", 100)
    monkeypatch.setattr(compiler, "MOST_STATEMENTS", 10)
    files = [SourceFile(f"{number}.st", text) for number, text in enumerate(texts, 1)]
    with pytest.raises(CompileError, match=message) as refused:
        compile_project(files, StandaloneHost(VirtualClock()))
    assert len(refused.value.mistakes) == 1


@pytest.mark.long
@pytest.mark.parametrize("part", ["? ", "yy := zz;\n", "x := TRUE;\n", "IF x THEN ) END_IF;\n"])
def test_messages_end_after_a_thousand(part: str) -> None:
    text = program("x : INT;", "".join(part.replace("zz", f"zz{number}") for number in range(3_000)))
    with pytest.raises(CompileError) as refused:
        compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()))
    assert 1_000 <= len(refused.value.mistakes) <= 2_002


def arrays(count: int, size: int) -> str:
    """Lists of global variables, each within its own limit."""
    return " ".join(f"VAR_GLOBAL g{number} : ARRAY[1..{size}] OF BYTE; END_VAR" for number in range(count))


@pytest.mark.manual("PD-316")
@pytest.mark.parametrize("size", [131_072, 131_073])
def test_an_array_has_at_most_128_kbyte(size: int) -> None:
    expected = [] if size <= 131_072 else [f"1:22 a has {size} bytes; at most 131072 bytes (PD-316)"]
    assert messages(program(f"a : ARRAY[1..{size}] OF BYTE;")) == expected


@pytest.mark.manual("PD-316")
def test_an_array_has_at_most_32_kbyte_in_older_firmware() -> None:
    text = program("a : ARRAY[1..32769] OF BYTE;")
    assert messages(text) == []
    assert messages(text, limits=limits_of(Version(0, 11))) == ["1:22 a has 32769 bytes; at most 32768 bytes (PD-316)"]


@pytest.mark.manual("PD-316")
def test_a_structure_and_a_list_of_global_variables_have_the_same_limit() -> None:
    structure = "TYPE S : STRUCT a, b : ARRAY[1..70000] OF BYTE; END_STRUCT END_TYPE"
    assert messages(structure, program("s : S;")) == ["1:22 s has 140000 bytes; at most 131072 bytes (PD-316)"]
    both = "VAR_GLOBAL a : ARRAY[1..70000] OF BYTE; b : ARRAY[1..70000] OF BYTE; END_VAR"
    assert messages(both) == ["1:1 this list has 140000 bytes; at most 131072 bytes (PD-316)"]


@pytest.mark.manual("PD-316")
def test_an_instance_counts_with_the_blocks_in_it() -> None:
    inner = "FUNCTION_BLOCK I VAR a : ARRAY[1..70000] OF BYTE; END_VAR ; END_FUNCTION_BLOCK"
    outer = "FUNCTION_BLOCK O VAR a, b : I; END_VAR ; END_FUNCTION_BLOCK"
    assert messages(inner, outer) == [
        "1:1 an instance of O has 140000 bytes, with the blocks in it; at most 131072 bytes (PD-316)"
    ]


@pytest.mark.manual("PD-312")
@pytest.mark.manual("PD-313")
def test_all_variables_together_have_at_most_1900544_bytes() -> None:
    assert messages(arrays(14, 131_072), arrays(1, 65_536).replace("g0", "h")) == []  # 14 * 131072 + 65536 = 1900544
    (found,) = messages(arrays(14, 131_072), arrays(1, 65_537).replace("g0", "h"))
    assert found.endswith("all variables have 1900545 bytes; at most 1900544 bytes (PD-313)")


@pytest.mark.manual("PD-315")
def test_retain_variables_fit_into_the_memory_that_the_controller_has_for_them() -> None:
    text = "VAR_GLOBAL RETAIN a : ARRAY[1..1025] OF BYTE; END_VAR"
    assert messages(text) == []
    (found,) = messages(text, limits=replace(MAX_4, retain=1024))
    assert found.endswith("the RETAIN variables have 1025 bytes; at most 1024 bytes (PD-315)")


@pytest.mark.manual("PD-314")
@pytest.mark.parametrize(
    ("address", "kind", "expected"),
    [
        ("%MB65535", "BYTE", []),
        ("%MB65536", "BYTE", ["%MB65536 is byte 65536 of its area; a byte below 65536 (PD-314)"]),
        ("%QD16383", "DWORD", []),
        ("%QD16384", "DWORD", ["%QD16384 is byte 65536 of its area; a byte below 65536 (PD-314)"]),
        ("%IW32768", "WORD", ["%IW32768 is byte 65536 of its area; a byte below 65536 (PD-314)"]),
    ],
)
def test_each_area_has_64_kbyte(address: str, kind: str, expected: list[str]) -> None:
    found = messages(program(f"x AT {address} : {kind};"))
    assert [message.partition(" ")[2] for message in found] == expected


@pytest.mark.manual("PD-321")
def test_bits_are_located_in_the_first_4096_bytes() -> None:
    assert messages(program("x AT %MX2047.15 : BOOL; y AT %QX32767 : BOOL;")) == []
    found = messages(program("x AT %MX2048.0 : BOOL; y AT %QX32768 : BOOL; z AT %MW2048 : WORD;"))
    assert [message.partition(" ")[2] for message in found] == [
        "the bit %MX2048.0 is in byte 4096; a bit in the first 4096 bytes (PD-321)",
        "the bit %QX32768 is in byte 4096; a bit in the first 4096 bytes (PD-321)",
    ]


@pytest.mark.manual("PD-317")
def test_the_variables_of_a_function_fit_on_the_stack() -> None:
    def function(size: int) -> str:
        return f"FUNCTION F : INT VAR a : ARRAY[1..{size}] OF BYTE; END_VAR F := a[1]; END_FUNCTION"

    assert messages(function(10_238)) == []
    assert messages(function(10_239)) == [
        "1:1 the variables of F on the stack have 10241 bytes; at most 10240 bytes (PD-317)"
    ]


@pytest.mark.manual("PD-318")
@pytest.mark.parametrize("depth", [15, 16])
def test_if_is_nested_15_deep(depth: int) -> None:
    nested = "IF b THEN " * depth + "b := FALSE; " + "END_IF; " * depth
    expected = [] if depth == 15 else ["3:151 IF is nested 16 deep; at most 15 (PD-318)"]
    assert messages(program("b : BOOL;", nested)) == expected


@pytest.mark.manual("PD-318")
def test_an_if_behind_another_is_no_nesting() -> None:
    inner = "IF b THEN b := FALSE; END_IF; " * 16
    assert messages(program("b : BOOL;", f"{inner} IF b THEN {inner} END_IF")) == []


@pytest.mark.manual("PD-318")
def test_elsif_is_no_nesting() -> None:
    branches = "ELSIF x = 1 THEN x := 2; " * 30
    assert messages(program("x : INT;", f"IF x = 0 THEN x := 1; {branches} END_IF")) == []


@pytest.mark.manual("PD-310")
@pytest.mark.parametrize("count", [64, 65])
def test_there_are_at_most_64_tasks(count: int) -> None:
    tasks = " ".join(
        f"TASK T{n}(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM I{n} WITH T{n} : PLC_PRG;" for n in range(count)
    )
    found = messages(program("x : INT;"), f"CONFIGURATION C RESOURCE R ON PLC {tasks} END_RESOURCE END_CONFIGURATION")
    assert [message.partition(" ")[2] for message in found] == (
        [] if count == 64 else ["65 tasks; at most 64 (PD-310)"]
    )
