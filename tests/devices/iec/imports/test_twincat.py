"""Files of TwinCAT 3: POUs, types, global variables and tasks."""

import pytest
from exchange_documents import messages, read, unit_of

from fieldrig_devices.iec import tree


def tc(content: str) -> str:
    return (
        '\ufeff<?xml version="1.0" encoding="utf-8"?>\n'
        f'<TcPlcObject Version="1.1.0.1" ProductVersion="3.1.4024.12">\n{content}\n</TcPlcObject>\n'
    )


FB = tc("""  <POU Name="FB_Belt" Id="{11111111-2222-3333-4444-555555555555}" SpecialFunc="None">
    <Declaration><![CDATA[// the belt
FUNCTION_BLOCK FB_Belt
VAR_INPUT
	bRun : BOOL; // from the panel
END_VAR
VAR
	nCount : INT;
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[IF bRun THEN
	nCount := nCount + 1; // products
END_IF]]></ST>
    </Implementation>
    <Action Name="Reset" Id="{11111111-2222-3333-4444-555555555556}">
      <Implementation>
        <ST><![CDATA[nCount := 0;]]></ST>
      </Implementation>
    </Action>
    <LineIds Name="FB_Belt">
      <LineId Id="3" Count="2" />
    </LineIds>
  </POU>""")


def test_a_function_block_with_an_action() -> None:
    unit, mistakes = read(FB, "FB_Belt.TcPOU")
    assert mistakes == []
    assert (
        unit.declarations
        == unit_of("""
        FUNCTION_BLOCK FB_Belt
        VAR_INPUT bRun : BOOL; END_VAR
        VAR nCount : INT; END_VAR
        IF bRun THEN nCount := nCount + 1; END_IF
        END_FUNCTION_BLOCK
        ACTION Reset: nCount := 0; END_ACTION""").declarations
    )


def test_line_numbers_are_those_of_the_file() -> None:
    unit, _ = read(FB)
    (pou,) = unit.declarations
    assert isinstance(pou, tree.Pou)
    assert isinstance(pou.body, tree.StBody)
    lines = FB.split("\n")
    assert "IF bRun" in lines[pou.body.statements[0].position.line - 1]
    assert isinstance(pou.actions[0].body, tree.StBody)
    assert "nCount := 0" in lines[pou.actions[0].body.statements[0].position.line - 1]
    (message,) = messages(FB.replace("nCount := 0;", "nCount := ;"))
    assert message.startswith(f"test.xml:{pou.actions[0].body.statements[0].position.line}:")


def test_a_comment_at_the_end_of_a_body_does_not_hide_its_end() -> None:
    unit, mistakes = read(FB.replace("END_IF]]>", "END_IF // done]]>"))
    assert mistakes == []
    assert len(unit.declarations) == 1


def test_a_list_of_global_variables_keeps_its_name() -> None:
    text = tc("""  <GVL Name="GVL_Belt" Id="{1}">
    <Declaration><![CDATA[{attribute 'qualified_only'}
VAR_GLOBAL
	rSpeed : REAL := 1.5;
END_VAR]]></Declaration>
  </GVL>""")
    unit, mistakes = read(text, "GVL_Belt.TcGVL")
    assert mistakes == []
    assert unit.declarations == unit_of("VAR_GLOBAL rSpeed : REAL := 1.5; END_VAR").declarations
    assert isinstance(unit.declarations[0], tree.Variables)
    assert unit.declarations[0].name == "GVL_Belt"


def test_a_type() -> None:
    text = tc("""  <DUT Name="E_State" Id="{1}">
    <Declaration><![CDATA[TYPE E_State :
(
	IDLE := 0,
	RUN := 5
);
END_TYPE
]]></Declaration></DUT>""")
    unit, mistakes = read(text, "E_State.TcDUT")
    assert mistakes == []
    assert unit.declarations == unit_of("TYPE E_State : (IDLE := 0, RUN := 5); END_TYPE").declarations


def test_an_enumeration_with_texts_is_a_type() -> None:
    text = tc("""  <EnumerationTextList Name="E_Order" Id="{1}">
    <Declaration><![CDATA[TYPE E_Order : (Before, After)BYTE; END_TYPE
]]></Declaration>
    <XmlArchive><Data><o t="TextListEnumerationTextListObject"/></Data></XmlArchive>
  </EnumerationTextList>""")
    unit, mistakes = read(text, "E_Order.TcTLEO")
    assert mistakes == []
    assert unit.declarations == unit_of("TYPE E_Order : (Before, After) BYTE; END_TYPE").declarations


def test_a_task_calls_its_programs() -> None:
    text = tc("""  <Task Name="PlcTask" Id="{1}">
    <CycleTime>10000</CycleTime>
    <Priority>20</Priority>
    <PouCall><Name>MAIN</Name></PouCall>
  </Task>""")
    unit, mistakes = read(text, "PlcTask.TcTTO")
    assert mistakes == []
    (configuration,) = unit.declarations
    assert isinstance(configuration, tree.Configuration)
    assert configuration.programs == (tree.ProgramInstance("MAIN", "PlcTask", "MAIN"),)
    (task,) = configuration.tasks
    assert isinstance(task.interval, tree.Literal)
    assert isinstance(task.priority, tree.Literal)
    assert (task.interval.value, task.priority.value) == (10, 20)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (
            '<POU Name="P"><Declaration>PROGRAM P</Declaration><Implementation><NWL/></Implementation></POU>',
            "The body is in LD or FBD, as an archive of TwinCAT's editor",
        ),
        (
            '<POU Name="P"><Declaration>PROGRAM P</Declaration><Implementation><CFC/></Implementation></POU>',
            "hint: Export the POU as PLCopen XML in TwinCAT",
        ),
        ('<POU Name="P"><Implementation><ST>;</ST></Implementation></POU>', "The <Declaration> is missing"),
        ('<POU Name="P"><Declaration>VAR END_VAR</Declaration></POU>', "The declaration has no header"),
        (
            '<POU Name="P"><Declaration>PROGRAM P</Declaration><Property Name="M"/></POU>',
            "property M: The <Declaration> is missing",
        ),
        ("<TcVis/>", "The file contains TcVis; expected a POU, DUT, GVL or Task"),
        ('<Task Name="T"><CycleTime>fast</CycleTime></Task>', "CycleTime is fast; expected a whole number"),
    ],
)
def test_what_cannot_come_over_is_named(content: str, expected: str) -> None:
    assert any(expected in message for message in messages(tc(content))), messages(tc(content))


def test_an_interface_is_read_with_its_methods_and_properties() -> None:
    text = tc(
        '<Itf Name="I_Belt"><Declaration>INTERFACE I_Belt EXTENDS I_Any</Declaration>'
        '<Method Name="Run"><Declaration>METHOD Run : BOOL\nVAR_INPUT\n\tspeed : REAL;\nEND_VAR</Declaration></Method>'
        '<Property Name="Speed"><Declaration>PROPERTY Speed : REAL</Declaration>'
        '<Get Name="Get"><Declaration/></Get></Property></Itf>'
    )
    unit, mistakes = read(text, "I_Belt.TcIO")
    assert mistakes == []
    wanted = (
        "INTERFACE I_Belt EXTENDS I_Any METHOD Run : BOOL VAR_INPUT speed : REAL; END_VAR END_METHOD "
        "PROPERTY Speed : REAL GET END_GET END_PROPERTY END_INTERFACE"
    )
    assert unit.declarations == unit_of(wanted).declarations


def test_a_property_is_read_with_its_accessors() -> None:
    text = tc(
        '<POU Name="Belt"><Declaration>FUNCTION_BLOCK Belt\nVAR v : REAL; END_VAR</Declaration>'
        "<Implementation><ST>v := 0;</ST></Implementation>"
        '<Property Name="Speed"><Declaration>PROPERTY PUBLIC Speed : REAL</Declaration>'
        '<Get Name="Get"><Declaration>VAR\nEND_VAR</Declaration><Implementation><ST>Speed := v;</ST></Implementation>'
        '</Get><Set Name="Set"><Declaration/><Implementation><ST>v := Speed;</ST></Implementation></Set></Property>'
        "</POU>"
    )
    unit, mistakes = read(text, "Belt.TcPOU")
    assert mistakes == []
    (belt,) = unit.declarations
    assert isinstance(belt, tree.Pou)
    assert [(part.name, part.accessor, part.modifiers) for part in belt.methods] == [
        ("Speed", "GET", ("PUBLIC",)),
        ("Speed", "SET", ("PUBLIC",)),
    ]
