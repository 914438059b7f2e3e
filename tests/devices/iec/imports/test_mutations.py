"""No document makes an import raise: random changes of documents that hold every kind of element."""

import contextlib
import re
from collections.abc import Callable

from exchange_documents import block, coil, contact, pou, rail, sink, source, tc6
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import PlainHost

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.compiler import SourceFile, compile_project
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.printer import print_unit
from fieldrig_devices.languages.mistakes import CompileError

_WIRE = '<connectionPointIn><connection refLocalId="{}"/></connectionPointIn>'

NETWORKS = tc6(
    '<dataTypes><dataType name="T"><baseType><array><dimension lower="1" upper="3"/><baseType><struct>'
    '<variable name="a"><type><INT/></type><initialValue><simpleValue value="3"/></initialValue></variable></struct>'
    "</baseType></array></baseType></dataType></dataTypes>"
    + pou(
        f"<LD>{rail()}{contact('1', 'a', '0', attributes='edge=' + repr('rising'))}{contact('2', 'b', '0')}"
        f"{contact('3', 'c', '1', '2')}{coil('4', 'm', '3', attributes='storage=' + repr('set'))}"
        + source("5", "n + 1")
        + block("6", "ADD", {"EN": "3", "IN1": "5", "IN2": "6.OUT"}, "ENO OUT")
        + block("7", "TON", {"IN": "6.ENO", 'PT negated="true"': "5"}, "Q ET", 'instanceName="t1"')
        + sink("8", "n", "6.OUT")
        + sink("9", "x", "7.Q", attributes='negated="true"')
        + '<label localId="10" label="end"/><jump localId="11" label="end">'
        + _WIRE.format(3)
        + '</jump><return localId="12"/><connector localId="13" name="K">'
        + _WIRE.format(2)
        + '</connector><continuation localId="14" name="K"/>'
        + coil("15", "k", "14")
        + "</LD>",
        variables={"a": "BOOL", "b": "BOOL", "n": "INT", "t1": '<derived name="TON"/>'},
    )
)

CHART = tc6(
    pou(
        "<SFC>"
        '<step localId="1" name="S" initialStep="true"><connectionPointOut formalParameter="s"/></step>'
        f'<selectionDivergence localId="2">{_WIRE.format(1)}</selectionDivergence>'
        f'<transition localId="3" priority="1">{_WIRE.format(2)}<condition><inline name=""><ST>'
        "<xhtml:p>a AND b</xhtml:p></ST></inline></condition></transition>"
        f'<transition localId="4">{_WIRE.format(2)}<condition><reference name="Go"/></condition></transition>'
        f'<simultaneousDivergence localId="5" name="F">{_WIRE.format(3)}</simultaneousDivergence>'
        f'<step localId="6" name="A">{_WIRE.format(5)}</step><step localId="7" name="B">{_WIRE.format(5)}</step>'
        f'<actionBlock localId="8">{_WIRE.format(6)}<action qualifier="D" duration="T#3s"><reference name="lamp"/>'
        "</action><action><inline><ST><xhtml:p>n := 1;</xhtml:p></ST></inline></action></actionBlock>"
        f'<simultaneousConvergence localId="9">{_WIRE.format(6)}{_WIRE.format(7)}</simultaneousConvergence>'
        f'<inVariable localId="10"><expression>a</expression></inVariable><transition localId="11">{_WIRE.format(9)}'
        f'<condition negated="true">{_WIRE.format(10)}</condition></transition>'
        f'<selectionConvergence localId="12">{_WIRE.format(4)}{_WIRE.format(11)}</selectionConvergence>'
        f'<jumpStep localId="13" targetName="S">{_WIRE.format(12)}</jumpStep></SFC>',
        more='<actions><action name="lamp"><body><IL><xhtml:p>LD a\nST b</xhtml:p></IL></body></action></actions>'
        '<transitions><transition name="Go"><body><ST><xhtml:p>a</xhtml:p></ST></body></transition></transitions>',
    ),
    instances='<configuration name="c"><resource name="r"><task name="t" priority="1" interval="PT0.01S">'
    '<pouInstance name="P" typeName=""/></task><globalVars name="G"><variable name="g" address="%QX1.0"><type><BOOL/>'
    "</type></variable></globalVars></resource></configuration>",
)

PART_10 = (
    '<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><Types>'
    '<GlobalNamespace><DataTypeDecl name="E"><UserDefinedTypeSpec xsi:type="EnumTypeWithNamedValueSpec"><Enumerator '
    'name="R" value="1"/><BaseType>INT</BaseType></UserDefinedTypeSpec></DataTypeDecl><Program name="P"><Vars '
    'accessSpecifier="private"><Variable name="a"><Type><TypeName>BOOL</TypeName></Type></Variable></Vars><MainBody>'
    '<BodyContent xsi:type="LD"><Rung evaluationOrder="1" label="l"><LdObject xsi:type="LeftPowerRail">'
    '<ConnectionPointOut connectionPointOutId="1"/></LdObject><LdObject xsi:type="Contact" operand="a" edge="rising">'
    '<ConnectionPointIn><Connection refConnectionPointOutId="1"/></ConnectionPointIn><ConnectionPointOut '
    'connectionPointOutId="2"/></LdObject><FbdObject xsi:type="Block" typeName="ADD"><InputVariables><InputVariable '
    'parameterName="IN1"><ConnectionPointIn><FeedbackConnection refConnectionPointOutId="3" feedbackVariable="f"/>'
    '</ConnectionPointIn></InputVariable></InputVariables><OutputVariables><OutputVariable parameterName="OUT">'
    '<ConnectionPointOut connectionPointOutId="3"/></OutputVariable></OutputVariables></FbdObject><LdObject '
    'xsi:type="Coil" operand="m" latch="set"><ConnectionPointIn><Connection refConnectionPointOutId="2"/>'
    "</ConnectionPointIn></LdObject></Rung></BodyContent></MainBody></Program></GlobalNamespace></Types><Instances>"
    '<Configuration name="c"><Resource name="r"><Task name="t" interval="T#5ms" priority="3"/><ProgramInstance name="p"'
    ' typeName="P" associatedTaskName="t"/></Resource></Configuration></Instances></Project>'
)

TWINCAT = (
    '<TcPlcObject><POU Name="P"><Declaration><![CDATA[PROGRAM P\nVAR a : INT; END_VAR]]></Declaration><Implementation>'
    '<ST><![CDATA[a := 1; // x]]></ST></Implementation><Action Name="A"><Implementation><ST>a := 2;</ST>'
    "</Implementation></Action></POU></TcPlcObject>"
)
ENI = "<pou><name>P</name><interface><![CDATA[PROGRAM P]]></interface><st><body><![CDATA[;]]></body></st></pou>"
DOCUMENTS = (NETWORKS, CHART, PART_10, TWINCAT, ENI)

_PARTS = re.compile(r"<[^>]*>|[^<]+")
_VALUES = re.compile(r'"[^"]*"')
_ODD = ("", "0", "1", "-1", "a", "1e999", "9" * 30, "???", "T#1s", "%QX", "\u00e4", "(", "P", "none", "x.y[1]", "''")


def _without(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    return parts[:at] + parts[at + 1 :]


def _twice(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    return [*parts[:at], parts[at], *parts[at:]]


def _moved(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    to = draw(len(parts) - 1)
    rest = _without(parts, at, draw)
    return [*rest[:to], parts[at], *rest[to:]]


def _other_value(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    values = _VALUES.findall("".join(parts))
    new = values[draw(len(values) - 1)] if draw(1) and values else f'"{_ODD[draw(len(_ODD) - 1)]}"'
    return [*parts[:at], _VALUES.sub(lambda _: new, parts[at], count=1), *parts[at + 1 :]]


def _whole_element_away(parts: list[str], at: int, draw: Callable[[int], int]) -> list[str]:
    """Stays well-formed, so that the readers see it."""
    name = re.match(r"<([\w:]+)", parts[at])
    if name is None or parts[at].endswith("/>"):
        return _without(parts, at, draw)
    depth = 0
    for end in range(at, len(parts)):
        opened = re.match(r"<(/?)" + re.escape(name.group(1)) + r"[\s>/]", parts[end])
        if opened is not None and not parts[end].endswith("/>"):
            depth += -1 if opened.group(1) else 1
        if depth == 0:
            return parts[:at] + parts[end + 1 :]
    return parts


_CHANGES = (_other_value, _other_value, _whole_element_away, _whole_element_away, _without, _twice, _moved)


@st.composite
def changed(draw_: st.DrawFn, most: int) -> str:
    """A document with some changes."""
    parts = _PARTS.findall(DOCUMENTS[draw_(st.integers(0, len(DOCUMENTS) - 1))])

    def draw(last: int) -> int:
        return draw_(st.integers(0, max(0, last)))

    for _ in range(draw(most)):
        change = draw_(st.sampled_from(_CHANGES))
        parts = change(parts, draw(len(parts) - 1), draw) or [""]
    return "".join(parts)


@settings(deadline=None)
@given(changed(3))
def test_a_changed_document_compiles_or_is_refused(document: str) -> None:
    """The trees that an import makes are sound enough for every stage behind it."""
    with contextlib.suppress(CompileError):
        compile_project([SourceFile("x.xml", document)], PlainHost())


@settings(deadline=None)
@given(changed(6), st.sampled_from((EPAS_4, EDITION_3)))
def test_a_changed_document_is_read_with_messages(document: str, dialect: Dialect) -> None:
    unit, mistakes = read_source("x.xml", document, dialect)
    assert isinstance(unit, tree.Unit)
    assert all(mistake.file == "x.xml" and mistake.line >= 1 for mistake in mistakes)
    print_unit(unit)  # every tree that an import makes can be written


@settings(deadline=None)
@given(st.text(alphabet=st.characters(codec="utf-8")) | st.text(alphabet="<>/=\"' &;pouTcPlcObject\n"))
def test_any_text_is_read_with_messages(text: str) -> None:
    read_source("x", text, EPAS_4)
    read_source("x", f"<{text}", EPAS_4)


def test_the_documents_are_sound_before_they_are_changed() -> None:
    for document in DOCUMENTS:
        _, mistakes = read_source("x.xml", document, EDITION_3)
        assert not [mistake for mistake in mistakes if "XML is damaged" in mistake.what]
