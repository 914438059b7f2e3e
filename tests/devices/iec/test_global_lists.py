"""Named lists of global variables, as TwinCAT has one in each file, may have variables of the same name."""

import pytest
from iec_program import PlainHost

from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, Dialect
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

MAIN = """
FUNCTION_BLOCK Motor
VAR id : INT; END_VAR
METHOD FB_init : BOOL VAR_INPUT bInitRetains, bInCopyCode : BOOL; n : INT; END_VAR id := n; END_METHOD
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR speeds, motors, ids, plain, elements : INT; END_VAR
speeds := Left.speed + Right.speed;
motors := Left.Motor + Right.Motor;
ids := Left.first.id * 10 + Right.first.id;
plain := speed;
elements := SIZEOF(Left.list) / 2 * 10 + SIZEOF(Right.list) / 2;
Right.speed := 70;
END_PROGRAM
"""


def listed(name: str, number: int, elements: int) -> SourceFile:
    text = f"""VAR_GLOBAL
    first : Motor({number});
    speed : INT := 2 * {number} + n;
    Motor : INT := {number};
    list : ARRAY[1..n] OF INT;
END_VAR
VAR_GLOBAL CONSTANT
    n : INT := {elements};
END_VAR"""
    xml = f'<GVL Name="{name}" Id="1"><Declaration><![CDATA[{text}]]></Declaration></GVL>'
    return SourceFile(f"{name}.TcGVL", f'<TcPlcObject Version="1.1.0.1">{xml}</TcPlcObject>')


FILES = [listed("Left", 5, 4), listed("Right", 7, 6), SourceFile("main.st", MAIN)]


def values(dialect: Dialect) -> dict[str, Value]:
    host = PlainHost()
    compiled = compile_project(FILES, host, dialect)
    runtime = Runtime(compiled, host)
    thread = runtime.thread(compiled.program.pous["plc_prg"])
    thread.start()
    while thread.state is WorkState.READY:
        thread.run(1_000_000)
    paths = [f"PLC_PRG.{name}" for name in ("speeds", "motors", "ids", "plain", "elements")]
    return {path: runtime.read(runtime.find(path)) for path in [*paths, "Right.speed", "speed", "Right.first.id"]}


def test_a_name_of_two_lists_means_the_variable_of_the_list_in_front_of_it() -> None:
    assert values(CODESYS) == {
        "PLC_PRG.speeds": 2 * 5 + 4 + 2 * 7 + 6,
        "PLC_PRG.motors": 12,
        "PLC_PRG.ids": 57,
        "PLC_PRG.plain": 14,
        "PLC_PRG.elements": 46,
        "Right.speed": 70,
        "speed": 14,
        "Right.first.id": 7,
    }


def test_the_standard_has_one_name_space() -> None:
    with pytest.raises(CompileError, match=r"speed is declared in Left\.TcGVL"):
        values(EDITION_3)


QUALIFIED = """{attribute 'qualified_only'}
VAR_GLOBAL CONSTANT
    Double : BOOL := TRUE;
    LEN : INT := 5;
    size : INT := LEN + 1;
END_VAR
VAR_GLOBAL
    level : INT := size;
END_VAR"""
FUNCTION = """
FUNCTION Double : INT VAR_INPUT n : INT; END_VAR Double := 2 * n; END_FUNCTION
PROGRAM PLC_PRG
VAR a, b, c, d : INT; END_VAR
a := Double(4);
b := LEN('abc');
c := Param.LEN + Param.size;
IF Param.Double THEN d := Param.level; END_IF
END_PROGRAM
"""


def qualified(text: str) -> SourceFile:
    xml = f'<GVL Name="Param" Id="1"><Declaration><![CDATA[{text}]]></Declaration></GVL>'
    return SourceFile("Param.TcGVL", f'<TcPlcObject Version="1.1.0.1">{xml}</TcPlcObject>')


@pytest.mark.parametrize("is_first", [True, False])
def test_names_of_a_list_that_is_qualified_only_hide_nothing(is_first: bool) -> None:
    files = [qualified(QUALIFIED), SourceFile("main.st", FUNCTION)]
    host = PlainHost()
    compiled = compile_project(files if is_first else files[::-1], host, CODESYS)
    runtime = Runtime(compiled, host)
    thread = runtime.thread(compiled.program.pous["plc_prg"])
    thread.start()
    while thread.state is WorkState.READY:
        thread.run(1_000_000)
    assert [runtime.read(runtime.find(f"PLC_PRG.{name}")) for name in "abcd"] == [8, 3, 11, 6]
    assert runtime.read(runtime.find("Param.level")) == 6


def test_a_name_of_such_a_list_means_nothing_without_the_list() -> None:
    main = "PROGRAM PLC_PRG VAR a : INT; END_VAR a := level; END_PROGRAM"
    with pytest.raises(CompileError, match="level is not declared"):
        compile_project([qualified(QUALIFIED), SourceFile("main.st", main)], PlainHost(), CODESYS)
