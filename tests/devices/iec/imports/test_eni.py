"""Objects of the ENI: the manual's example (6296 to 6333), and what is not in it."""

import pytest
from exchange_documents import LISTING_57, messages, unit_of

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.iec.imports import read_source


@pytest.mark.manual("PD-345")
def test_the_manuals_object_is_the_program_in_it() -> None:
    unit, mistakes = read_source("ST_EXAMPLE.xml", LISTING_57, EPAS_4)
    assert mistakes == []
    assert (
        unit.declarations
        == unit_of("""
        PROGRAM ST_EXAMPLE
        VAR
          YVAL : INT := -250;
          BOTTOM : INT := -250;
          RUN_STRING : STRING(20) := 'Start';
          OFFSET : INT := 2;
        END_VAR
        RUN_STRING := 'Start';
        IF (YVAL < 0) THEN
          YVAL := YVAL + OFFSET;
          BOTTOM := YVAL + OFFSET;
        END_IF;
        END_PROGRAM""").declarations
    )


def test_messages_have_the_lines_of_the_file() -> None:
    unit, _ = read_source("x.xml", LISTING_57, EPAS_4)
    (program,) = unit.declarations
    assert isinstance(program, tree.Pou)
    assert isinstance(program.body, tree.StBody)
    assert [statement.position.line for statement in program.body.statements] == [19, 20]
    (message,) = messages(LISTING_57.replace("YVAL + OFFSET;\n    BOTTOM", "YVAL + ;\n    BOTTOM"))
    assert message.startswith("test.xml:21:")
    assert "object ST_EXAMPLE" in message


def test_an_object_with_declarations_alone() -> None:
    text = "<gvl><name>Globals</name><interface><![CDATA[VAR_GLOBAL\n  speed : REAL;\nEND_VAR]]></interface></gvl>"
    unit, mistakes = read_source("x.xml", text, EPAS_4)
    assert mistakes == []
    assert unit.declarations == unit_of("VAR_GLOBAL speed : REAL; END_VAR").declarations


def test_graphic_bodies_say_what_to_do() -> None:
    text = "<pou><name>P</name><interface>PROGRAM P</interface><ld><body/></ld></pou>"
    (message,) = messages(text)
    assert "object P: The body is in LD" in message
    assert "hint: Convert the POU to ST or IL" in message


def test_an_object_without_declarations_is_a_message() -> None:
    assert any("The object has no <interface>" in message for message in messages("<pou><name>P</name></pou>"))
