"""A configuration with several resources, of which a controller runs one."""

import pytest
from iec_check import messages
from iec_program import PlainHost

from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.program_file import Container

TEXT = """\
PROGRAM Fill
VAR_EXTERNAL
    level : INT;
    both : INT;
END_VAR

level := level + 1;
END_PROGRAM

PROGRAM Pack
VAR_EXTERNAL
    boxes : INT;
    both : INT;
END_VAR

boxes := boxes + both;
END_PROGRAM

CONFIGURATION Line
    VAR_GLOBAL
        both : INT := 5;
    END_VAR
    RESOURCE Filler ON PLC
        VAR_GLOBAL
            level : INT;
            speed : INT := 1;
        END_VAR
        TASK Main(INTERVAL := T#10ms);
        PROGRAM one WITH Main : Fill;
    END_RESOURCE
    RESOURCE Packer ON PLC
        VAR_GLOBAL
            boxes : INT;
            speed : INT := 2;
        END_VAR
        TASK Main(INTERVAL := T#20ms);
        PROGRAM two WITH Main : Pack;
    END_RESOURCE
END_CONFIGURATION
"""


def compiled(resource: str, text: str = TEXT) -> Compiled:
    return compile_project([SourceFile("main.st", text)], PlainHost(), resource=resource)


def refused(resource: str, text: str = TEXT) -> str:
    with pytest.raises(CompileError) as wrong:
        compiled(resource, text)
    (mistake,) = (found for found in wrong.value.mistakes if not found.is_note)
    return str(mistake)


@pytest.mark.parametrize(
    ("resource", "interval_ms", "program", "speed"), [("Filler", 10, "Fill", 1), ("PACKER", 20, "Pack", 2)]
)
def test_the_named_resource_gives_tasks_and_global_variables(
    resource: str, interval_ms: int, program: str, speed: int
) -> None:
    found = compiled(resource).program
    (task,) = found.tasks
    assert (task.interval_ms, [pou.name for pou in task.programs]) == (interval_ms, [program])
    assert (found.globals["speed"].initial, found.globals["both"].initial) == (speed, 5)


def test_without_a_name_there_is_a_message_with_all_names_and_the_key() -> None:
    assert refused("") == (
        "main.st:31:5: there are the resources Filler, Packer, and a controller runs one of them; "
        "expected the key resource of the controller, or --resource, with its name"
    )


def test_a_wrong_name_is_refused() -> None:
    assert "there is no resource Mixer; expected Filler, Packer" in refused("Mixer")
    alone = "PROGRAM PLC_PRG END_PROGRAM"
    assert "there is no resource Mixer; expected a RESOURCE in the source" in refused("Mixer", alone)


def test_with_one_resource_no_name_is_needed() -> None:
    one = TEXT[: TEXT.index("    RESOURCE Packer")] + "VAR_GLOBAL boxes : INT; END_VAR END_CONFIGURATION"
    assert [task.interval_ms for task in compiled("", one).program.tasks] == [10]
    assert compiled("Filler", one).program.tasks[0].name == "Main"
    assert not messages(one)


def test_several_resources_are_printed_as_they_were_written() -> None:
    unit, mistakes = parse(TEXT, "main.st", EPAS_4)
    assert mistakes == []
    assert print_unit(unit) == TEXT


def test_the_program_file_keeps_the_name_of_the_resource() -> None:
    container = Container((SourceFile("main.st", TEXT),), "epas-4", "Packer")
    assert Container.decode(container.encode()) == container
    without = Container((SourceFile("main.st", ""),), "epas-4")
    assert b"resource" not in without.encode()
    assert Container.decode(without.encode()) == without
