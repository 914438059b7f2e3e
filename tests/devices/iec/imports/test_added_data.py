"""PLCopen XML: arguments of FB_init, objects that are excluded, version 1.01, and one message for one mistake."""

import pytest
from exchange_documents import pou, read, sink, source, tc6
from iec_program import IecBench, refused

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, DIALECTS, EDITION_3

DATA = "http://www.3s-software.com/plcopenxml/"
HEAD = f'handleUnknown="implementation" name="{DATA}'


def arguments(*given: tuple[str, str]) -> str:
    rows = "".join(
        f"<InputAssignment>{f'<Name>{name}</Name>' if name else ''}<Value>{value}</Value></InputAssignment>"
        for name, value in given
    )
    return f'<addData><data {HEAD}inputassignments"><InputAssignments>{rows}</InputAssignments></data></addData>'


def variable(name: str, kind: str, more: str = "") -> str:
    declared = kind if kind.startswith("<") else f"<{kind}/>"
    return f'<variable name="{name}"><type>{declared}</type>{more}</variable>'


INIT = (
    f'<addData><data {HEAD}method"><Method name="FB_init" ObjectId="1"><interface><returnType><BOOL/></returnType>'
    f"<inputVars>{variable('bInitRetains', 'BOOL')}{variable('bInCopyCode', 'BOOL')}{variable('address', 'INT')}"
    "</inputVars></interface><body><ST>a := address;</ST></body></Method></data></addData>"
)
METER = (
    f'<pou name="Meter" pouType="functionBlock"><interface><localVars>{variable("a", "INT")}</localVars></interface>'
    f"<body><ST>;</ST></body>{INIT}</pou>"
)
OF_METER = '<derived name="Meter"/>'
METERS = f'<array><dimension lower="1" upper="2"/><baseType>{OF_METER}</baseType></array>'


def document(variables: str, body: str) -> str:
    interface = f"<interface><localVars>{variables}</localVars></interface>"
    return tc6(f'<pous>{METER}<pou name="P" pouType="program">{interface}<body>{body}</body></pou></pous>')


@pytest.mark.parametrize("name", ["address", ""])
def test_the_arguments_of_a_declaration_reach_fb_init(name: str) -> None:
    """CODESYS writes them with the name of the input, or without for arguments by position."""
    declared = variable("m", OF_METER, arguments((name, "3 + 4"))) + variable("got", "INT")
    bench = IecBench(document(declared, "<ST>got := m.a;</ST>"), CODESYS, main="P")
    bench.cycle()
    assert bench["got"] == 7


def test_the_arguments_of_an_array_reach_each_instance() -> None:
    declared = variable("m", METERS, arguments(("address", "5"))) + variable("got", "INT")
    bench = IecBench(document(declared, "<ST>got := m[1].a * 10 + m[2].a;</ST>"), CODESYS, main="P")
    bench.cycle()
    assert bench["got"] == 55


def test_arguments_without_fb_init_are_refused_where_the_dialect_has_none() -> None:
    _, found = read(document(variable("m", OF_METER, arguments(("address", "7"))), "<ST>;</ST>"))
    assert [mistake.what for mistake in found if not mistake.is_note] == [
        "PROGRAM P, variable m: The variable has arguments for FB_init"
    ]


def test_an_object_that_is_excluded_from_the_build_is_left_out() -> None:
    flag = "<BuildProperties><ExcludeFromBuild>true</ExcludeFromBuild></BuildProperties>"
    added = f'<addData><data {HEAD}buildproperties">{flag}</data></addData>'
    wrong = f'<pou name="Old" pouType="program"><interface/><body><ST>nonsense</ST></body>{added}</pou>'
    right = '<pou name="P" pouType="program"><interface/><body><ST>;</ST></body></pou>'
    unit, found = read(tc6(f"<pous>{wrong}{right}</pous>"))
    assert [getattr(declared, "name", "") for declared in unit.declarations] == ["P"]
    assert [(mistake.what, mistake.is_note) for mistake in found] == [
        ("Old is left out: it is excluded from the build", True)
    ]


@pytest.mark.parametrize(
    ("added", "note"),
    [
        (f'<data name="{DATA}timetravel"/>', f"The added data {DATA}timetravel is left out"),
        ('<data name="http://example.org/f"><Force/></data>', "The added data http://example.org/f is left out"),
        (f'<data name="{DATA}attributes"><Attributes><Attribute Name="call_after_init"/></Attributes></data>',
         "The attribute call_after_init is left out"),
        (f'<data name="{DATA}attributes"><Attributes><Attribute Name="pack_mode" Value="4"/></Attributes></data>',
         "The attribute pack_mode is left out"),
        (f'<data name="{DATA}objectid"><ObjectId>1</ObjectId></data>', None),
        (f'<data name="{DATA}attributes"><Attributes><Attribute Name="qualified_only"/></Attributes></data>', None),
    ],
)  # fmt: skip
def test_added_data_that_nobody_reads_is_named(added: str, note: str | None) -> None:
    _, found = read(tc6(pou("<ST>;</ST>", more=f"<addData>{added}{added}</addData>")))
    assert [mistake.what for mistake in found] == ([note] if note else [])
    assert all(mistake.is_note for mistake in found)


def test_a_union_of_an_export_of_codesys() -> None:
    """`x` and `y` are at the same address, so that y shows the bits of 1.0."""
    fields = variable("x", "REAL") + variable("y", "DWORD")
    union = f'<addData><data {HEAD}union"><union name="Both">{fields}</union></data></addData>'
    declared = variable("u", '<derived name="Both"/>') + variable("got", "DWORD")
    text = document(declared, "<ST>u.x := 1.0; got := u.y;</ST>").replace("</project>", f"{union}</project>")
    bench = IecBench(text, CODESYS, main="P")
    bench.cycle()
    assert bench["got"] == 0x3F800000


def test_an_enumeration_of_another_type() -> None:
    values = '<values><value name="a" value="70000"/></values><baseType><UDINT/></baseType>'
    types = f'<dataTypes><dataType name="E"><baseType><enum>{values}</enum></baseType></dataType></dataTypes>'
    text = tc6(types + pou("<ST>n := TO_UDINT(a);</ST>", variables={"n": "UDINT"}))
    bench = IecBench(text, EDITION_3, main="P")
    bench.cycle()
    assert bench["n"] == 70000


@pytest.mark.parametrize(
    ("interval", "milliseconds"),
    [("00:00:00.100000", 100), ("00:01:02", 62_000), ("01:00:00.5", 3_600_500), ("T#20ms", 20), ("PT0.5S", 500)],
)
def test_version_1_01_has_type_and_a_clock_as_the_interval(interval: str, milliseconds: int) -> None:
    task = (
        f'<configuration name="c"><resource name="r"><task name="t" interval="{interval}" priority="0">'
        '<pouInstance name="i" type="P"/></task></resource></configuration>'
    )
    text = tc6(pou("<ST>n := n + 1;</ST>", variables={"n": "INT"}), version="0101", instances=task)
    unit, found = read(text.replace("tc6_0101", "tc6.xsd"))
    assert not found
    (configuration,) = (one for one in unit.declarations if isinstance(one, tree.Configuration))
    assert getattr(configuration.tasks[0].interval, "value", None) == milliseconds
    assert [program.type for program in configuration.programs] == ["P"]


# ---- one message for one mistake


MISSING = """
TYPE S : STRUCT a : Missing; b : INT; END_STRUCT; L : ARRAY[1..3] OF Missing; END_TYPE
FUNCTION F : Missing
VAR_INPUT x : Missing; END_VAR
F := x; F := F + 1;
END_FUNCTION
FUNCTION_BLOCK Tile
VAR_INPUT x : Missing := 3; END_VAR
VAR_OUTPUT q : Missing; END_VAR
x := q;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR t : Tile; u, v : Missing; i : INT; s : S; l : L; b : BOOL; a : ARRAY[0..1] OF Missing := [1, 2]; END_VAR
t(x := 0, q => i); i := t.q; u := i; i := u + 1; u := u + v; b := u > 3; u.x := 5; i := u.x.y; u[3] := 5;
s.a := 3; i := s.a + s.b; l[1] := 4; i := F(1); u := F(2) + F(x := v);
IF u THEN i := 1; END_IF; CASE u OF 1: i := 2; END_CASE; FOR u := 1 TO 3 DO i := i; END_FOR;
i := INT_TO_REAL(u); i := ABS(u); i := MAX(u, 1); i := SEL(b, u, 1); u := NOT u; u := -u; a[0] := 'abc'; u(x := 3);
END_PROGRAM
"""


@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_follows_from_a_missing_type_is_not_reported(dialect: str) -> None:
    found = [text for text in refused(MISSING, DIALECTS[dialect]) if "note:" not in text]
    assert found
    assert all("the type Missing is not declared" in text for text in found), found


@pytest.mark.parametrize("dialect", ["edition-3", "codesys"])
def test_what_follows_from_a_missing_base_is_not_reported(dialect: str) -> None:
    text = """FUNCTION_BLOCK Suite EXTENDS Framework.TestSuite
VAR n : INT; END_VAR
METHOD Adds : INT
TEST('Adds'); AssertEquals(a := 1, b := 2); n := Count(); inherited := 3; SUPER^.Adds(); SUPER^(); Adds := 1;
END_METHOD
inherited := n + other; Reset();
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR s : Suite; i : INT; END_VAR
s(speed := 3); s.Run(); i := s.count; i := s.Total(1); i := s.Adds();
END_PROGRAM"""
    found = [text for text in refused(text, DIALECTS[dialect]) if "note:" not in text]
    assert len(found) == 1, found
    assert "Framework.TestSuite is not declared" in found[0]


def test_what_follows_from_an_unknown_type_in_a_drawing_is_not_reported() -> None:
    body = f"<FBD>{source('1', 'a')}{sink('2', 'b', '1')}</FBD>"
    _, found = read(tc6(pou(body, variables={"a": "<nonsense/>", "b": "REAL"})))
    assert len(found) == 1
    messages_ = refused(tc6(pou(body, variables={"a": "<nonsense/>", "b": "REAL"})), EDITION_3)
    assert sum("note:" not in text for text in messages_) == 1, messages_
