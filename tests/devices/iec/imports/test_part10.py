"""Documents of IEC 61131-10, with the habits of the tools that write them."""

import pytest
from exchange_documents import messages, only_pou, read, st, unit_of
from iec_program import IecBench
from object_documents import PART10_CLASSES, XSI, body, content, part10, result

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.imports import read_source


def program(body: str, variables: str = "") -> str:
    given = f'<Vars accessSpecifier="private">{variables}</Vars>' if variables else ""
    return part10(f'<Program name="P">{given}<MainBody>{body}</MainBody></Program>')


def variable(name: str, type: str, more: str = "") -> str:
    return f'<Variable name="{name}"><Type><TypeName>{type}</TypeName></Type>{more}</Variable>'


def wires(*points: int) -> str:
    found = "".join(f'<Connection refConnectionPointOutId="{point}"/>' for point in points)
    return f"<ConnectionPointIn>{found}</ConnectionPointIn>"


def out(point: int) -> str:
    return f'<ConnectionPointOut connectionPointOutId="{point}"/>'


def ld(kind: str, inside: str, attributes: str = "") -> str:
    return f'<LdObject xsi:type="{kind}" {attributes}>{inside}</LdObject>'


def fbd(kind: str, inside: str, attributes: str = "") -> str:
    return f'<FbdObject xsi:type="{kind}" {attributes}>{inside}</FbdObject>'


def test_declarations_and_structured_text() -> None:
    parameters = (
        '<Parameters><InputVars><Variable name="x" orderWithinParamSet="0"><Type><TypeName>INT</TypeName></Type>'
        '</Variable></InputVars><OutputVars retain="true">'
        '<Variable name="y" orderWithinParamSet="1"><Type><TypeName>INT</TypeName></Type></Variable></OutputVars>'
        "</Parameters>"
    )
    local = variable("n", "DINT", '<InitialValue><SimpleValue value="5"/></InitialValue><Address address="%MD4"/>')
    text = part10(
        f'<FunctionBlock name="F">{parameters}<ExternalVars constant="true">{variable("limit", "INT")}</ExternalVars>'
        f'<Vars accessSpecifier="private">{local}</Vars>'
        f"<MainBody>{content('ST', '<ST><![CDATA[y := x + 1;]]></ST>')}</MainBody></FunctionBlock>"
    )
    expected = unit_of("""
        FUNCTION_BLOCK F
        VAR_INPUT x : INT; END_VAR
        VAR_OUTPUT RETAIN y : INT; END_VAR
        VAR n AT %MD4 : DINT := 5; END_VAR
        VAR_EXTERNAL CONSTANT limit : INT; END_VAR
        y := x + 1;
        END_FUNCTION_BLOCK""").declarations[0]
    assert isinstance(expected, tree.Pou)
    found = only_pou(text)
    assert (found.kind, found.name, found.body) == (expected.kind, expected.name, expected.body)
    assert sorted(found.blocks, key=str) == sorted(expected.blocks, key=str)


def test_a_function_has_a_result() -> None:
    text = part10(
        '<Function name="F"><ResultType><TypeName>LREAL</TypeName></ResultType>'
        f"<MainBody>{content('ST', '<ST>F := 1.0;</ST>')}</MainBody></Function>"
    )
    found = only_pou(text)
    assert (found.result, found.body) == (tree.NamedType("LREAL"), tree.StBody(st("F := 1.0;")))


TYPES = [
    (
        'xsi:type="StructTypeSpec"',
        '<Member name="a"><Type><TypeName>REAL</TypeName></Type></Member>',
        "STRUCT a : REAL; END_STRUCT",
    ),
    ('xsi:type="EnumTypeSpec"', '<Enumerator name="RED"/><Enumerator name="GREEN"/>', "(RED, GREEN);"),
    (
        'xsi:type="EnumTypeWithNamedValueSpec"',
        '<Enumerator name="RED" value="3"/><BaseType>DINT</BaseType>',
        "(RED := 3);",
    ),
    (
        'xsi:type="ArrayTypeSpec"',
        (
            "<BaseType><TypeName>STRING[20]</TypeName></BaseType>"
            '<DimensionSpec><IndexRange lower="0" upper="3"/></DimensionSpec>'
        ),
        "ARRAY[0..3] OF STRING[20];",
    ),
    ('xsi:type="DirectlyDerivedTypeSpec"', "<BaseType><TypeName>Common\\AXIS</TypeName></BaseType>", "AXIS;"),
]


@pytest.mark.parametrize(("attributes", "inside", "expected"), TYPES)
def test_types_have_the_form_of_the_language(attributes: str, inside: str, expected: str) -> None:
    text = part10(
        f'<DataTypeDecl name="T"><UserDefinedTypeSpec {attributes}>{inside}</UserDefinedTypeSpec></DataTypeDecl>'
    )
    unit, mistakes = read(text)
    assert mistakes == []
    assert unit.declarations == unit_of(f"TYPE T : {expected} END_TYPE").declarations


def test_types_inside_of_name_spaces_and_arrays_in_place() -> None:
    array = (
        '<Variable name="v"><Type><InstantlyDefinedType xsi:type="ArrayTypeSpec"><BaseType><TypeName>INT</TypeName>'
        '</BaseType><DimensionSpec dimensionNumber="1"><IndexRange lower="1" upper="4"/></DimensionSpec>'
        "</InstantlyDefinedType></Type></Variable>"
    )
    found = only_pou(program(content("ST", "<ST>;</ST>"), array))
    assert found.blocks == (
        tree.Variables(
            tree.Section.LOCAL,
            (unit_of("VAR_GLOBAL v : ARRAY[1..4] OF INT; END_VAR").declarations[0].variables[0],),  # type: ignore[union-attr]
        ),
    )


def test_rungs_are_networks_and_evaluated_in_their_order() -> None:
    second = (
        '<Rung evaluationOrder="2">'
        + ld("LeftPowerRail", out(1))
        + ld("Contact", wires(1) + out(2), 'operand="a"')
        + ld("Contact", wires(1) + out(3), 'operand="b" negated="true"')
        + ld("Coil", wires(2, 3) + out(4), 'operand="m"')
        + ld("RightPowerRail", wires(4))
        + "</Rung>"
    )
    first = (
        '<Rung evaluationOrder="1"><CommonObject xsi:type="Comment"><Content xsi:type="SimpleText">latch</Content>'
        "</CommonObject>"
        + ld("LeftPowerRail", out(1))
        + ld("Contact", wires(1) + out(2), 'operand="a" edge="rising"')
        + ld("Coil", wires(2) + out(3), 'operand="m" latch="set"')
        + ld("RightPowerRail", wires(3))
        + "</Rung>"
    )
    body = only_pou(program(content("LD", second + first))).body
    assert isinstance(body, tree.StBody)
    assert body.statements == st("""
        Net1_Edge2 := a AND NOT Net1_Before1; Net1_Before1 := a; IF Net1_Edge2 THEN m := TRUE; END_IF
        m := a OR NOT b;""")
    assert body.statements[0].comments == ("(* latch *)",)


def test_sections_of_one_vendor_are_executed_one_after_the_other() -> None:
    rung = '<Rung evaluationOrder="1">{}{}</Rung>'
    late = content("smcext:LdSection", rung.format(ld("LeftPowerRail", out(1)), ld("Coil", wires(1), 'operand="m"')),
                   'name="B" evaluationOrder="2"')  # fmt: skip
    early = content("smcext:LdSection", rung.format(ld("LeftPowerRail", out(1)), ld("Coil", wires(1), 'operand="n"')),
                    'name="A" evaluationOrder="1"')  # fmt: skip
    text = program(late + early).replace("<Project ", '<Project xmlns:smcext="https://www.ia.omron.com/Smc" ')
    assert only_pou(text).body == tree.StBody(st("n := TRUE; m := TRUE;"))


def test_blocks_sources_and_sinks_of_a_network() -> None:
    block = fbd(
        "Block",
        f'<InputVariables><InputVariable parameterName="x">{wires(1)}</InputVariable>'
        f'<InputVariable parameterName="y" negated="true">{wires(2)}</InputVariable></InputVariables>'
        f'<OutputVariables><OutputVariable parameterName="AND">{out(3)}</OutputVariable></OutputVariables>',
        'typeName="AND"',
    )
    network = (
        '<Network xsi:type="FbdNetwork" evaluationOrder="1">'
        + fbd("DataSource", out(1), 'identifier="a"')
        + fbd("DataSource", out(2), 'identifier="b"')
        + block
        + fbd("DataSink", wires(3), 'identifier="c"')
        + "</Network>"
    )
    assert only_pou(program(content("FBD", network))).body == tree.StBody(st("c := a AND NOT b;"))


def test_a_feedback_variable_carries_the_value_of_the_previous_cycle() -> None:
    feedback = (
        '<ConnectionPointIn><FeedbackConnection refConnectionPointOutId="2" feedbackVariable="loop"/>'
        "</ConnectionPointIn>"
    )
    pins = (
        f'<InputVariables><InputVariable parameterName="IN1">{wires(1)}</InputVariable>'
        f'<InputVariable parameterName="IN2">{feedback}</InputVariable></InputVariables>'
        f'<OutputVariables><OutputVariable parameterName="OUT">{out(2)}</OutputVariable></OutputVariables>'
    )
    source = fbd("DataSource", out(1), 'identifier="a"')
    network = f'<Network evaluationOrder="1">{source}{fbd("Block", pins, "typeName=" + repr("ADD"))}</Network>'
    assert only_pou(program(content("FBD", network))).body == tree.StBody(st("loop := a + loop;"))


def test_labels_and_jumps_between_networks() -> None:
    first = (
        '<Network evaluationOrder="1">'
        + fbd("DataSource", out(1), 'identifier="a"')
        + fbd("Jump", wires(1), 'targetNetworkLabel="last"')
        + "</Network>"
    )
    last = (
        '<Network evaluationOrder="2" label="last">'
        + fbd("DataSource", out(1), 'identifier="b"')
        + fbd("DataSink", wires(1), 'identifier="c"')
        + "</Network>"
    )
    assert only_pou(program(content("FBD", first + last))).body == tree.StBody(
        st("IF a THEN JMP last; END_IF last: c := b;")
    )


def test_a_single_pou_with_declarations_as_text() -> None:
    """One vendor's files have the POU as their root, and the order of evaluation in data of its own."""

    def priority(number: int) -> str:
        return (
            '<ppx:AddData><ppx:Data name="http://www.bachmann.at/xml/PLC" handleUnknown="implementation">'
            f'<EvaluationPriority priorityInNetwork="{number}"/></ppx:Data></ppx:AddData>'
        )

    def sink(name: str, order: int) -> str:
        return (
            f'<ppx:FbdObject xsi:type="ppx:DataSink" identifier="{name}" globalId="{name}">{priority(order)}'
            '<ppx:ConnectionPointIn><ppx:Connection refConnectionPointOutId="2"/></ppx:ConnectionPointIn>'
            "</ppx:FbdObject>"
        )

    text = (
        f'<ppx:Program xmlns:ppx="www.iec.ch/public/TC65SC65BWG7TF10" {XSI} name="chain"><ppx:AddData>'
        '<ppx:Data name="http://www.bachmann.at/xml/PLC" handleUnknown="implementation"><textDeclaration><content>'
        "PROGRAM chain\nVAR\n  foo, bar, baz : DINT;\nEND_VAR\n</content></textDeclaration></ppx:Data></ppx:AddData>"
        '<ppx:MainBody><ppx:BodyContent xsi:type="ppx:FBD"><ppx:Network>'
        '<ppx:FbdObject xsi:type="ppx:DataSource" identifier="foo" globalId="1"><ppx:ConnectionPointOut '
        f'connectionPointOutId="2"/></ppx:FbdObject>{sink("bar", 1)}{sink("baz", 0)}'
        "</ppx:Network></ppx:BodyContent></ppx:MainBody></ppx:Program>"
    )
    found = only_pou(text)
    assert found.body == tree.StBody(st("baz := foo; bar := foo;"))
    assert [v.name for v in found.blocks[0].variables] == ["foo", "bar", "baz"]


def test_tasks_and_programs_of_a_resource() -> None:
    resource = (
        '<Configuration name="c"><Resource name="r" resourceTypeName="PLC">'
        f"<GlobalVars>{variable('speed', 'REAL')}</GlobalVars>"
        '<Task xsi:type="StandardTask" name="Cyclic10ms" interval="T#10ms" priority="1"/>'
        '<ProgramInstance name="MAIN" typeName="MAIN" associatedTaskName="Cyclic10ms"/></Resource></Configuration>'
    )
    unit, mistakes = read(part10("", resource))
    assert mistakes == []
    globals_, configuration = unit.declarations
    assert globals_ == unit_of("VAR_GLOBAL speed : REAL; END_VAR").declarations[0]
    assert isinstance(configuration, tree.Configuration)
    assert configuration.programs == (tree.ProgramInstance("MAIN", "Cyclic10ms", "MAIN"),)
    assert [task.name for task in configuration.tasks] == ["Cyclic10ms"]


def test_a_chart_by_analogy_with_tc6() -> None:
    network = (
        '<Network evaluationOrder="1">'
        f'<SfcObject xsi:type="Step" name="S1" initialStep="true">{wires(4)}{out(1)}</SfcObject>'
        f'<SfcObject xsi:type="Transition">{wires(1)}{out(2)}'
        f"<Condition><Inline>{content('ST', '<ST>a</ST>')}</Inline></Condition></SfcObject>"
        f'<SfcObject xsi:type="Step" name="S2">{wires(2)}{out(3)}</SfcObject>'
        f'<SfcObject xsi:type="Transition">{wires(3)}{out(4)}<Condition><Reference name="b"/></Condition></SfcObject>'
        f'<CommonObject xsi:type="ActionBlock">{wires(3)}<Action qualifier="N"><Reference name="lamp"/></Action>'
        "</CommonObject>"
        "</Network>"
    )
    body = only_pou(program(content("SFC", network))).body
    assert isinstance(body, tree.SfcBody)
    assert [(t.sources, t.targets) for t in body.transitions] == [(("S1",), ("S2",)), (("S2",), ("S1",))]
    assert body.steps[1].uses == (tree.ActionUse("lamp", "N"),)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            part10('<Class name="C"><Method name="M"><Pragma/></Method></Class>'),
            "CLASS C, method M: A method has the element Pragma, which is not known; expected ResultType, Parameters",
        ),
        (part10('<Class name="1"/>'), '"1" cannot be the name of a POU'),
        (part10('<Interface name="1"/>'), '"1" cannot be the name of an interface'),
        (part10('<Class name="C"><Method name="1"/></Class>'), '"1" cannot be the name of a method'),
        (program(content("CFC", "")), "The body has the type cfc; expected ST, IL, LD, FBD or SFC"),
        (
            program(content("FBD", f"<Network>{fbd('DataSink', wires(7), 'identifier=' + repr('a'))}</Network>")),
            "The output point 7 is not there",
        ),
        (program(content("FBD", f"<Network>{fbd('x:Magic', '')}</Network>")), "known only to the tool that wrote it"),
        (
            program(
                content("LD", f"<Rung>{ld('Coil', wires(), 'operand=' + repr('m') + ' latch=' + repr('hold'))}</Rung>")
            ),
            "has latch='hold'; expected none, set, reset",
        ),
        (part10('<DataTypeDecl name="T"/>'), "type T: The type has no specification"),
        (program(content("ST", "<ST>;</ST>"), '<Variable name="v"/>'), "variable v: The type is missing"),
    ],
)
def test_what_cannot_come_over_is_named(text: str, expected: str) -> None:
    assert any(expected in message for message in messages(text)), read(text)[1]


def test_classes_interfaces_and_methods_are_those_of_the_language() -> None:
    unit, mistakes = read(PART10_CLASSES)
    assert mistakes == []
    assert (
        unit.declarations[:4]
        == unit_of("""
        INTERFACE Filling
        METHOD Fill : BOOL
        VAR_INPUT amount : REAL; END_VAR
        END_METHOD
        END_INTERFACE
        CLASS ABSTRACT Vessel IMPLEMENTS Filling
        VAR PROTECTED held : REAL; END_VAR
        METHOD PUBLIC ABSTRACT Room : REAL
        END_METHOD
        METHOD PUBLIC FINAL Fill : BOOL
        VAR_INPUT amount : REAL; END_VAR
        IF held + amount <= Room() THEN held := held + amount; Fill := TRUE; END_IF;
        END_METHOD
        END_CLASS
        CLASS Drum EXTENDS Vessel
        VAR PUBLIC height : REAL; END_VAR
        METHOD PUBLIC OVERRIDE Room : REAL
        Room := 3.0 * height;
        END_METHOD
        END_CLASS
        FUNCTION_BLOCK FINAL Pump
        VAR n : INT; END_VAR
        Step();
        METHOD PUBLIC Step
        n := n + 1;
        END_METHOD
        END_FUNCTION_BLOCK""").declarations
    )
    running = IecBench(PART10_CLASSES, EDITION_3)
    running.cycle()
    assert (running["a"], running["b"]) == (True, False)


@pytest.mark.parametrize(
    ("dialect", "text", "expected"),
    [
        (CODESYS, '<Class name="C"/>', "The class C is not supported; expected functions, function blocks and actions"),
        (EPAS_4, '<Interface name="I"/>', "The interface I is not supported"),
        (EPAS_4, '<FunctionBlock name="F"><Method name="M"/></FunctionBlock>', "FUNCTION_BLOCK F: The method M is not"),
        (
            EPAS_4,
            '<FunctionBlock name="F"><Extends><TypeName>G</TypeName></Extends></FunctionBlock>',
            "FUNCTION_BLOCK F: EXTENDS is not supported",
        ),
    ],
)
def test_objects_need_a_dialect_that_has_them(dialect: Dialect, text: str, expected: str) -> None:
    (message,) = read_source("test.xml", part10(text), dialect)[1]
    assert expected in str(message)
    assert message.hint == "Choose the dialect edition-3."


def test_an_interface_of_another_file_is_left_out_with_a_note() -> None:
    text = part10('<FunctionBlock name="F"><Implements><TypeName>Shop.Filling</TypeName></Implements></FunctionBlock>')
    (note,) = read(text)[1]
    assert note.is_note
    assert note.what == "FUNCTION_BLOCK F: IMPLEMENTS Filling is left out"


def test_an_array_without_limits_has_stars() -> None:
    """The form is that of the text; no document of a tool has one."""
    stars = '<IndexRange lower="*" upper="*"/>'
    kind = (
        '<Type><InstantlyDefinedType xsi:type="ArrayTypeSpec"><BaseType><TypeName>INT</TypeName></BaseType>'
        f'<DimensionSpec dimensionNumber="1">{stars}</DimensionSpec>'
        f'<DimensionSpec dimensionNumber="2">{stars}</DimensionSpec></InstantlyDefinedType></Type>'
    )
    given = f'<Parameters><InoutVars><Variable name="a">{kind}</Variable></InoutVars></Parameters>'
    text = part10(f'<Function name="F">{result("INT")}{given}{body("F := a[1, 1];")}</Function>')
    expected = "FUNCTION F : INT VAR_IN_OUT a : ARRAY[*, *] OF INT; END_VAR F := a[1, 1]; END_FUNCTION"
    assert read(text)[0].declarations == unit_of(expected).declarations
    (message,) = read_source("test.xml", text, EPAS_4)[1]
    assert "An array has the limit *; expected limits such as 1..10" in str(message)
