"""Projects of PLCopen TC6 as tools write them: types, declarations, tasks, and vendors' habits."""

import pytest
from exchange_documents import messages, only_pou, pou, read, st, tc6, unit_of
from iec_program import IecBench
from object_documents import CODESYS_OBJECTS, added

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, EPAS_4
from fieldrig_devices.iec.imports import read_source

ST = "<ST><xhtml:p>;</xhtml:p></ST>"


def declarations(text: str) -> tuple[tree.Declaration, ...]:
    unit, mistakes = read(text)
    assert mistakes == []
    return unit.declarations


def variable(name: str, type: str, value: str = "", address: str = "") -> str:
    at = f' address="{address}"' if address else ""
    start = f"<initialValue>{value}</initialValue>" if value else ""
    return f'<variable name="{name}"{at}><type>{type}</type>{start}</variable>'


def simple(value: str) -> str:
    return f'<simpleValue value="{value}"/>'


def interface(content: str, kind: str = "functionBlock") -> str:
    return tc6(f'<pous><pou name="P" pouType="{kind}"><interface>{content}</interface><body>{ST}</body></pou></pous>')


BASE_TYPES = [
    ("<REAL/>", "REAL"),
    ("<TOD/>", "TOD"),
    ('<string length="20"/>', "STRING[20]"),
    ("<string/>", "STRING"),
    ('<derived name="MOTOR"/>', "MOTOR"),
    ('<array><dimension lower="1" upper="N"/><dimension lower="-2" upper="2"/><baseType><INT/></baseType></array>',
     "ARRAY[1..N, -2..2] OF INT"),
    ('<array><dimension lower="0" upper="3"/><baseType><derived name="MOTOR"/></baseType></array>',
     "ARRAY[0..3] OF MOTOR"),
    ('<subrangeSigned><range lower="-10" upper="10"/><baseType><INT/></baseType></subrangeSigned>', "INT(-10..10)"),
    ('<subrangeUnsigned><range lower="0" upper="9"/><baseType><UINT/></baseType></subrangeUnsigned>', "UINT(0..9)"),
    ("<pointer><baseType><DINT/></baseType></pointer>", "POINTER TO DINT"),
    ('<enum><values><value name="RED"/><value name="GREEN" value="5"/></values></enum>', "(RED, GREEN := 5)"),
]  # fmt: skip


@pytest.mark.parametrize(("written", "expected"), BASE_TYPES)
def test_types_have_the_form_of_the_language(written: str, expected: str) -> None:
    text = tc6(f'<dataTypes><dataType name="T"><baseType>{written}</baseType></dataType></dataTypes><pous/>')
    assert declarations(text) == unit_of(f"TYPE T : {expected}; END_TYPE").declarations


def test_structures_have_fields_with_start_values() -> None:
    fields = variable("speed", "<REAL/>", simple("1.5")) + variable("name", '<string length="8"/>', simple("'belt'"))
    text = tc6(
        f'<dataTypes><dataType name="AXIS"><baseType><struct>{fields}</struct></baseType></dataType></dataTypes><pous/>'
    )
    expected = "TYPE AXIS : STRUCT speed : REAL := 1.5; name : STRING[8] := 'belt'; END_STRUCT END_TYPE"
    assert declarations(text) == unit_of(expected).declarations


VALUES = [
    ("<INT/>", simple("-250"), "INT := -250"),
    ("<BYTE/>", simple("16#FF"), "BYTE := 16#FF"),
    ("<TIME/>", simple("T#1d2h"), "TIME := T#1d2h"),
    ("<BOOL/>", simple("TRUE"), "BOOL := TRUE"),
    ("<REAL/>", simple("3.14e-2"), "REAL := 3.14e-2"),
    ("<string/>", simple("'a$Nb'"), "STRING := 'a$Nb'"),
    ('<derived name="COLOUR"/>', simple("RED"), "COLOUR := RED"),
    ('<array><dimension lower="1" upper="5"/><baseType><INT/></baseType></array>',
     f'<arrayValue><value repetitionValue="4">{simple("7")}</value><value>{simple("9")}</value></arrayValue>',
     "ARRAY[1..5] OF INT := [4(7), 9]"),
    ('<derived name="AXIS"/>',
     f'<structValue><value member="v">{simple("2.0")}</value><value member="on">{simple("TRUE")}</value></structValue>',
     "AXIS := (v := 2.0, on := TRUE)"),
]  # fmt: skip


@pytest.mark.parametrize(("type", "value", "expected"), VALUES)
def test_start_values_have_the_form_of_the_language(type: str, value: str, expected: str) -> None:
    found = only_pou(interface(f"<localVars>{variable('v', type, value)}</localVars>"))
    (pou_,) = unit_of(f"FUNCTION_BLOCK P VAR v : {expected}; END_VAR ; END_FUNCTION_BLOCK").declarations
    assert isinstance(pou_, tree.Pou)
    assert found.blocks == pou_.blocks


def test_a_string_without_quotes_is_a_string() -> None:
    found = only_pou(interface(f"<localVars>{variable('v', '<string/>', simple('Start 1'))}</localVars>"))
    assert found.blocks[0].variables[0].initial == tree.Literal(tree.LiteralKind.STRING, "Start 1")


SECTIONS = [
    ("localVars", "", "VAR"),
    ("localVars", 'retain="true"', "VAR RETAIN"),
    ("localVars", 'constant="true"', "VAR CONSTANT"),
    ("tempVars", "", "VAR_TEMP"),
    ("inputVars", 'retain="false"', "VAR_INPUT"),
    ("outputVars", 'retain="1"', "VAR_OUTPUT RETAIN"),
    ("inOutVars", "", "VAR_IN_OUT"),
    ("externalVars", 'constant="true"', "VAR_EXTERNAL CONSTANT"),
]


@pytest.mark.parametrize(("element", "attributes", "expected"), SECTIONS)
def test_every_kind_of_variables_comes_over(element: str, attributes: str, expected: str) -> None:
    found = only_pou(interface(f"<{element} {attributes}>{variable('v', '<INT/>')}</{element}>"))
    (pou_,) = unit_of(f"FUNCTION_BLOCK P {expected} v : INT; END_VAR ; END_FUNCTION_BLOCK").declarations
    assert isinstance(pou_, tree.Pou)
    assert found.blocks == pou_.blocks


@pytest.mark.parametrize("address", ["%IX5.0", "%QB3", "%MD48", "%I*"])
def test_addresses_come_over(address: str) -> None:
    text = interface(f"<localVars>{variable('v', '<BOOL/>', address=address)}</localVars>", "program")
    (expected,) = unit_of(f"PROGRAM P VAR v AT {address} : BOOL; END_VAR ; END_PROGRAM").declarations
    assert isinstance(expected, tree.Pou)
    assert only_pou(text).blocks == expected.blocks


def test_documentation_becomes_a_comment() -> None:
    text = interface(
        '<localVars><variable name="v"><type><INT/></type><documentation><xhtml:p>Number (*of*) axes</xhtml:p>'
        "</documentation></variable></localVars>"
    )
    assert only_pou(text).blocks[0].variables[0].remark == "(* Number ( *of* ) axes *)"


def test_a_function_has_a_result() -> None:
    text = interface("<returnType><REAL/></returnType><inputVars/>", "function")
    assert only_pou(text).result == tree.NamedType("REAL")


def test_tasks_programs_and_global_variables_of_a_configuration() -> None:
    configuration = (
        '<configuration name="c"><resource name="r">'
        '<task name="fast" priority="2" interval="T#4ms"><pouInstance name="i1" typeName="MAIN"/></task>'
        '<task name="event" priority="1" single="alarm"><pouInstance name="i2" typeName="ALARMS"/></task>'
        f'<globalVars constant="true">{variable("size", "<INT/>", simple("17"))}</globalVars>'
        '<pouInstance name="i3" typeName="IDLE"/></resource></configuration>'
    )
    found = declarations(tc6("<dataTypes/><pous/>", instances=configuration))
    assert found[0] == unit_of("VAR_GLOBAL CONSTANT size : INT := 17; END_VAR").declarations[0]
    (expected,) = unit_of("""
        CONFIGURATION r RESOURCE r ON PLC
        TASK fast(INTERVAL := T#4ms, PRIORITY := 2);
        TASK event(SINGLE := alarm, PRIORITY := 1);
        TASK Background(PRIORITY := 31);
        PROGRAM i1 WITH fast : MAIN; PROGRAM i2 WITH event : ALARMS; PROGRAM i3 WITH Background : IDLE;
        END_RESOURCE END_CONFIGURATION""").declarations
    assert isinstance(expected, tree.Configuration)
    expected.processor = ""
    assert found[1] == expected


def test_variables_of_the_configuration_have_paths() -> None:
    config = (
        '<configuration name="c"><resource name="r"/><configVars><configVariable instancePathAndName="PRG.lamp" '
        'address="%QX0.0"><type><BOOL/></type></configVariable></configVars></configuration>'
    )
    expected = unit_of("VAR_CONFIG PRG.lamp AT %QX0.0 : BOOL; END_VAR").declarations
    assert declarations(tc6("<dataTypes/><pous/>", instances=config)) == expected


def test_bodies_in_text_keep_the_lines_of_the_file() -> None:
    text = tc6(
        pou("\n\n<ST><xhtml:p><![CDATA[\na := 1;\n\nb := ;]]></xhtml:p></ST>", variables={"a": "INT", "b": "INT"})
    )
    (message,) = messages(text)
    assert message.startswith("test.xml:6:")
    assert "PROGRAM P" in message


@pytest.mark.parametrize(
    "body",
    [
        "<ST><xhtml:p><![CDATA[a := 1;\na := 2;]]></xhtml:p></ST>",
        '<ST><xhtml xmlns="http://www.w3.org/1999/xhtml">a := 1;\na := 2;</xhtml></ST>',
        '<ST><html xmlns="http://www.w3.org/1999/xhtml"><p>a := 1;<br/>// one\n</p><p>a := 2;</p></html></ST>',
        "<ST>a := 1;\na := 2;</ST>",
        '<ST><xhtml xmlns="http://www.w3.org/1999/xhtml"><div>a := 1; // one</div><div>a := 2;</div></xhtml></ST>',
    ],
)
def test_text_bodies_have_the_forms_of_several_tools(body: str) -> None:
    assert only_pou(tc6(pou(body, variables={"a": "INT"}))).body == tree.StBody(st("a := 1; a := 2;"))


# ---- habits of the CODESYS family


def test_an_application_inside_of_added_data() -> None:
    """CODESYS V3 and TwinCAT 3 write schema 2.00, XHTML, durations of ISO 8601, and empty types of instances."""
    application = (
        '<addData><data name="http://www.3s-software.com/plcopenxml/application" handleUnknown="implementation">'
        '<resource name="Application"><task name="MainTask" interval="PT0.01S" priority="1">'
        '<pouInstance name="PLC_PRG" typeName=""><documentation><xhtml xmlns="http://www.w3.org/1999/xhtml"/>'
        '</documentation></pouInstance><addData><data name="http://www.3s-software.com/plcopenxml/tasksettings" '
        'handleUnknown="implementation"><TaskSettings KindOfTask="Cyclic" Interval="t#10ms"/></data></addData></task>'
        f'<globalVars name="GVL">{variable("run", "<BOOL/>", simple("TRUE"))}</globalVars>'
        '<addData><data name="http://www.3s-software.com/plcopenxml/pou" handleUnknown="implementation">'
        '<pou name="PLC_PRG" pouType="program"><interface><localVars>'
        f'{variable("n", "<INT/>")}</localVars></interface><body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">'
        "n := n + 1;</xhtml></ST></body><addData>"
        '<data name="http://www.3s-software.com/plcopenxml/objectid" handleUnknown="discard"><ObjectId>2c7b</ObjectId>'
        "</data></addData></pou></data></addData></resource></data></addData></project>"
    )
    text = tc6("<dataTypes/><pous/>", version="0200").replace("</project>", application)
    globals_, program, configuration = declarations(text)
    assert isinstance(globals_, tree.Variables)
    assert (globals_.name, globals_.variables[0].name) == ("GVL", "run")
    assert isinstance(program, tree.Pou)
    assert program.body == tree.StBody(st("n := n + 1;"))
    assert isinstance(configuration, tree.Configuration)
    assert configuration.programs == (tree.ProgramInstance("PLC_PRG", "MainTask", "PLC_PRG"),)
    interval = configuration.tasks[0].interval
    assert isinstance(interval, tree.Literal)
    assert (interval.kind, interval.value) == (tree.LiteralKind.TIME, 10)


def test_declarations_as_text_stand_in_for_an_empty_interface() -> None:
    plain = (
        '<addData><data name="http://www.3s-software.com/plcopenxml/interfaceasplaintext" handleUnknown="preserve">'
        '<InterfaceAsPlainText><xhtml xmlns="http://www.w3.org/1999/xhtml">FUNCTION_BLOCK P\nVAR_INPUT\n'
        "  x : INT; // speed\nEND_VAR\nVAR\n y : BOOL;\nEND_VAR</xhtml></InterfaceAsPlainText></data></addData>"
    )
    text = tc6(f'<pous><pou name="P" pouType="functionBlock"><interface/><body>{ST}</body>{plain}</pou></pous>')
    assert [(b.section, b.variables[0].name) for b in only_pou(text).blocks] == [
        (tree.Section.INPUT, "x"),
        (tree.Section.LOCAL, "y"),
    ]


def test_ladder_networks_begin_with_a_title_and_share_one_rail() -> None:
    def title(id: str, comment: str) -> str:
        return (
            f'<comment localId="{id}" height="0" width="0"><position x="0" y="0"/><content>'
            f'<xhtml xmlns="http://www.w3.org/1999/xhtml">{comment}</xhtml></content></comment>'
            f'<vendorElement localId="{id}1"><position x="0" y="0"/><alternativeText>'
            '<xhtml xmlns="http://www.w3.org/1999/xhtml"/></alternativeText><addData>'
            '<data name="http://www.3s-software.com/plcopenxml/fbdelementtype" handleUnknown="implementation">'
            '<ElementType xmlns="">networktitle</ElementType></data></addData></vendorElement>'
        )

    def wire(*ids: str) -> str:
        found = "".join(f'<connection refLocalId="{id}"/>' for id in ids)
        return f'<position x="0" y="0"/><connectionPointIn>{found}</connectionPointIn>'

    ladder = (
        '<LD><leftPowerRail localId="0"><connectionPointOut formalParameter="none"/></leftPowerRail>'
        + title("1", "start and hold")
        + f'<contact localId="2" negated="false" storage="none" edge="none">{wire("0")}<variable>a</variable></contact>'
        + f'<contact localId="3">{wire("0")}<variable>m</variable></contact>'
        + f'<coil localId="4" negated="false" storage="none">{wire("2", "3")}<variable>m</variable></coil>'
        + title("5", "timer")
        + f'<contact localId="6">{wire("0")}<variable>m</variable></contact>'
        + '<inVariable localId="7"><connectionPointOut/><expression>t#3s</expression></inVariable>'
        + '<block localId="8" typeName="TON" instanceName="t1"><position x="0" y="0"/><inputVariables>'
        f'<variable formalParameter="IN">{wire("6")}</variable><variable formalParameter="PT">{wire("7")}</variable>'
        "</inputVariables><inOutVariables/><outputVariables>"
        '<variable formalParameter="Q"><connectionPointOut/></variable>'
        '<variable formalParameter="ET"><connectionPointOut><expression>e</expression></connectionPointOut></variable>'
        '</outputVariables><addData><data name="http://www.3s-software.com/plcopenxml/fbdcalltype" '
        'handleUnknown="implementation"><CallType xmlns="">functionblock</CallType></data></addData></block>'
        + '<coil localId="9"><position x="0" y="0"/><connectionPointIn><connection refLocalId="8" formalParameter="Q"/>'
        "</connectionPointIn><variable>n</variable></coil>"
        + f'<rightPowerRail localId="2147483646">{wire("4", "9")}</rightPowerRail></LD>'
    )
    body = only_pou(tc6(pou(ladder), version="0200")).body
    assert isinstance(body, tree.StBody)
    assert body.statements == st("m := a OR m; t1(IN := m, PT := t#3s); e := t1.ET; n := t1.Q;")
    assert [s.comments for s in body.statements] == [("(* start and hold *)",), ("(* timer *)",), (), ()]


def test_empty_operands_are_left_out() -> None:
    fbd = (
        '<FBD><inVariable localId="1"><connectionPointOut/><expression>???</expression></inVariable>'
        '<block localId="2" typeName="TON" instanceName="t1"><inputVariables><variable formalParameter="PT">'
        '<connectionPointIn><connection refLocalId="1"/></connectionPointIn></variable></inputVariables>'
        '<outputVariables><variable formalParameter="ET"><connectionPointOut><expression>???</expression>'
        "</connectionPointOut></variable></outputVariables></block></FBD>"
    )
    assert only_pou(tc6(pou(fbd))).body == tree.StBody(st("t1();"))


def test_a_box_with_code_is_executed_in_place() -> None:
    fbd = (
        '<FBD><inVariable localId="1"><connectionPointOut/><expression>a</expression></inVariable>'
        '<block localId="2" typeName="EXECUTE"><inputVariables><variable formalParameter="EN"><connectionPointIn>'
        '<connection refLocalId="1"/></connectionPointIn></variable></inputVariables><outputVariables>'
        '<variable formalParameter="ENO"><connectionPointOut/></variable></outputVariables><addData>'
        '<data name="http://www.3s-software.com/plcopenxml/stcode" handleUnknown="implementation">'
        "<STCode>b := 42;</STCode></data></addData></block></FBD>"
    )
    expected = st("Net1_Enable1 := a; IF Net1_Enable1 THEN b := 42; END_IF")
    assert only_pou(tc6(pou(fbd))).body == tree.StBody(expected)


def test_program_calls_have_no_instance() -> None:
    fbd = (
        '<FBD><block localId="2" typeName="Other"><inputVariables/><outputVariables/><addData>'
        '<data name="http://www.3s-software.com/plcopenxml/fbdcalltype" handleUnknown="implementation">'
        '<CallType xmlns="">program</CallType></data></addData></block></FBD>'
    )
    assert only_pou(tc6(pou(fbd))).body == tree.StBody(st("Other();"))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            tc6(pou('<ST><xhtml:p/></ST><addData><data name="x"><CFC/></data></addData>')),
            "continuous function chart, which is not part of the standard",
        ),
        (tc6(pou("<KOP/>")), "The body has no known language; expected IL, ST, FBD, LD, SFC"),
        (tc6('<pous><pou name="P" pouType="class"/></pous>'), "The POU P has the type class"),
        (tc6('<pous><pou name="1P" pouType="program"/></pous>'), '"1P" cannot be the name of a POU'),
        (interface("<localVars><variable name='v'><type/></variable></localVars>"), "variable v: The type is missing"),
        (interface(f"<localVars>{variable('v', '<ANY/>')}</localVars>"), "The type ANY is not known"),
        (interface(f"<localVars>{variable('v', '<INT/>', simple('5 6'))}</localVars>"), "variable v"),
        (interface(f"<localVars>{variable('v', '<INT/>', address='IX')}</localVars>"), "is not an address"),
        (tc6(pou('<FBD><error localId="1"><content>lost</content></error></FBD>')), "could not be exported: lost"),
        (
            tc6(
                pou(
                    '<FBD><vendorElement localId="3"><inputVariables><variable/></inputVariables></vendorElement></FBD>'
                )
            ),
            "Element 3 is known only to the tool that wrote it",
        ),
    ],
)
def test_what_cannot_come_over_is_named(text: str, expected: str) -> None:
    assert any(expected in message for message in messages(text)), read(text)[1]


def test_an_interface_of_a_library_is_left_out_with_a_note() -> None:
    text = tc6(pou(ST).replace("</interface>", "<addData><Implements>LIB.I_Run</Implements></addData></interface>"))
    (note,) = read(text)[1]
    assert note.is_note
    assert "IMPLEMENTS LIB.I_Run is left out" in note.what


def test_interfaces_and_access_specifiers_of_the_codesys_family() -> None:
    expected = unit_of("""
        INTERFACE I_Fill
        METHOD Fill : BOOL
        VAR_INPUT amount : INT; END_VAR
        END_METHOD
        PROPERTY Level : INT
        GET END_GET
        END_PROPERTY
        END_INTERFACE
        FUNCTION_BLOCK ABSTRACT Vessel IMPLEMENTS I_Fill
        VAR held : INT; END_VAR
        METHOD PROTECTED ABSTRACT Room : INT
        END_METHOD
        METHOD FINAL Fill : BOOL
        VAR_INPUT amount : INT; END_VAR
        Fill := held + amount <= Room(); IF Fill THEN held := held + amount; END_IF
        END_METHOD
        PROPERTY Level : INT
        GET Level := held; END_GET
        END_PROPERTY
        END_FUNCTION_BLOCK
        FUNCTION_BLOCK Drum EXTENDS Vessel
        METHOD PROTECTED Room : INT
        Room := 15;
        END_METHOD
        END_FUNCTION_BLOCK""").declarations
    unit, mistakes = read(CODESYS_OBJECTS)
    assert mistakes == []
    assert unit.declarations[:3] == expected
    running = IecBench(CODESYS_OBJECTS, CODESYS, name="plc.xml")
    running.cycle()
    assert [running[name] for name in ("a", "b", "n")] == [True, False, 12]


@pytest.mark.parametrize(
    "above",
    [
        added("pouinheritance", "<Inheritance><Extends>LIB.I_Low</Extends><Extends>I_High</Extends></Inheritance>"),
        added("pouinheritance", "<Inheritance><Extends>I_Low, I_High</Extends></Inheritance>"),
        (
            "<InterfaceAsPlainText><xhtml>INTERFACE I_Both // EXTENDS I_No\n"
            "EXTENDS I_Low, LIB.I_High</xhtml></InterfaceAsPlainText>"
        ),
    ],
)
def test_an_interface_extends_others(above: str) -> None:
    text = "<InterfaceAsPlainText><xhtml>METHOD Go : INT\nVAR_INPUT\n n : INT;\nEND_VAR</xhtml></InterfaceAsPlainText>"
    method = f'<Method name="Go"><interface><returnType><INT/></returnType></interface>{text}</Method>'
    found = added("interface", f'<Interface name="I_Both"><Methods>{method}</Methods>{above}</Interface>')
    found += "".join(added("interface", f'<Interface name="{name}"/>') for name in ("I_Low", "I_High"))
    document = tc6("<pous/>").replace("</project>", f"<addData>{found}</addData></project>")
    assert (
        declarations(document)
        == unit_of("""
        INTERFACE I_Both EXTENDS I_Low, I_High
        METHOD Go : INT
        VAR_INPUT n : INT; END_VAR
        END_METHOD
        END_INTERFACE
        INTERFACE I_Low END_INTERFACE
        INTERFACE I_High END_INTERFACE""").declarations
    )


def test_an_interface_needs_a_dialect_with_methods() -> None:
    found = [mistake for mistake in read_source("test.xml", CODESYS_OBJECTS, EPAS_4)[1] if not mistake.is_note]
    assert found[0].what == "The interface I_Fill is not supported"
    assert {mistake.hint for mistake in found} == {"Choose the dialect codesys."}


def test_a_structure_extends_another_one() -> None:
    above = added("datatypeinheritance", "<Inheritance><Extends>LIB.Spot</Extends></Inheritance>")
    types = (
        f'<dataType name="Spot"><baseType><struct>{variable("x", "<INT/>")}</struct></baseType></dataType>'
        f'<dataType name="Place"><baseType><struct>{variable("y", "<INT/>")}</struct></baseType>'
        f"<addData>{above}</addData></dataType>"
    )
    text = tc6(f"<dataTypes>{types}</dataTypes><pous/>")
    assert (
        declarations(text)
        == unit_of("""
        TYPE Spot : STRUCT x : INT; END_STRUCT END_TYPE
        TYPE Place EXTENDS Spot : STRUCT y : INT; END_STRUCT END_TYPE""").declarations
    )
    (message,) = read_source("test.xml", text, EPAS_4)[1]
    assert message.what == "type Place: EXTENDS is not supported here"


def test_a_list_with_constants_among_its_variables_is_there_once() -> None:
    """The list has all variables, and once more in parts with their attributes."""
    a, b, c = (variable(name, "<INT/>") for name in "abc")
    parts = (
        f'<globalVars name="GVL" constant="true">{b}</globalVars><globalVars name="GVL" retain="true">{a}</globalVars>'
    )
    mixed = added("mixedattrsvarlist", f"<MixedAttrsVarList>{parts}</MixedAttrsVarList>")
    list_ = f'<globalVars name="GVL">{a}{b}{c}<addData>{mixed}</addData></globalVars>'
    text = tc6("<pous/>").replace("</project>", f"<addData>{added('globalvars', list_)}</addData></project>")
    assert (
        declarations(text)
        == unit_of("""
        VAR_GLOBAL c : INT; END_VAR
        VAR_GLOBAL CONSTANT b : INT; END_VAR
        VAR_GLOBAL RETAIN a : INT; END_VAR""").declarations
    )
    assert [block.name for block in declarations(text) if isinstance(block, tree.Variables)] == ["GVL"] * 3


def test_a_function_without_a_result_has_none_where_the_dialect_knows_it() -> None:
    text = tc6(pou(ST, kind="function"))
    assert only_pou(text).result is None
    unit, (note,) = read_source("test.xml", text, EPAS_4)
    assert isinstance(unit.declarations[0], tree.Pou)
    assert unit.declarations[0].result == tree.NamedType("BOOL")
    assert "BOOL is assumed" in note.what
