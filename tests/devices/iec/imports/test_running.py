"""Imported programs run, and do the same as the same program in Structured Text."""

from functools import cache

import pytest
from exchange_documents import LISTING_57, block, coil, contact, pou, rail, sink, source, tc6
from hypothesis import given, settings
from hypothesis import strategies as st
from iec_program import ENOUGH_NS, IecBench, PlainHost, program

from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3
from fieldrig_devices.iec.runtime import Runtime, Start
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

BOOLS = dict.fromkeys(("start", "stop", "motor", "lamp", "done"), "BOOL")


@cache
def _compiled(document: str, main: str) -> IecBench:
    return IecBench(document, main=main)


def cold(document: str, main: str = "P") -> IecBench:
    """A program after a cold start; for many runs of the same program."""
    found = _compiled(document, main)
    found.runtime.initialise(Start.COLD)
    return found


def bench(document: str, main: str = "P") -> IecBench:
    return IecBench(document, main=main)


@pytest.mark.manual("PD-345")
def test_listing_57_counts_up_to_zero() -> None:
    running = IecBench(LISTING_57, main="ST_EXAMPLE")
    seen = []
    for _ in range(126):
        running.cycle()
        seen.append(running["YVAL"])
    assert seen == [*range(-248, 1, 2), 0]
    assert (running["BOTTOM"], running["RUN_STRING"]) == (2, "Start")


LADDER = tc6(
    pou(
        f"<LD>{rail()}"
        + contact("1", "start", "0", attributes='edge="rising"')
        + contact("2", "motor", "0")
        + contact("3", "stop", "1", "2", attributes='negated="true"')
        + coil("4", "motor", "3")
        + contact("5", "motor", "0")
        + coil("6", "lamp", "5", attributes='negated="true"')
        + coil("7", "done", "5", attributes='storage="set"')
        + "</LD>",
        variables=BOOLS,
    )
)
SAME_IN_ST = program(
    "start, stop, motor, lamp, done : BOOL; before, rising : BOOL;",
    """
    rising := start AND NOT before;
    before := start;
    motor := (rising OR motor) AND NOT stop;
    lamp := NOT motor;
    IF motor THEN done := TRUE; END_IF""",
)


@settings(deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=12))
def test_ladder_does_the_same_as_structured_text(inputs: list[tuple[bool, bool]]) -> None:
    drawn, written = cold(LADDER), cold(SAME_IN_ST, "PLC_PRG")
    for start, stop in inputs:
        for running in (drawn, written):
            running["start"], running["stop"] = start, stop
            running.cycle()
        for name in ("motor", "lamp", "done"):
            assert drawn[name] == written[name]


BLOCKS = tc6(
    pou(
        "<FBD>"
        + source("1", "a")
        + source("2", "b")
        + block("3", "GT", {"IN1": "1", "IN2": "2"})
        + block("4", "SEL", {"G": "3.OUT", "IN0": "2", "IN1": "1"})
        + sink("5", "larger", "4.OUT")
        + block("6", "MOVE", {"EN": "3.OUT", "IN": "1"}, "ENO OUT")
        + sink("7", "kept", "6.OUT")
        + sink("8", "moved", "6.ENO")
        + block("9", "ADD", {"IN1": "4.OUT", "IN2": "9.OUT"})
        + sink("10", "total", "9.OUT")
        + "</FBD>",
        variables={"a": "INT", "b": "INT", "larger": "INT", "kept": "INT", "moved": "BOOL", "total": "INT"},
    )
)
SMALL = st.integers(-2_000, 2_000)


@pytest.mark.long
@settings(deadline=None)
@given(st.lists(st.tuples(SMALL, SMALL), max_size=8))
def test_blocks_do_what_their_functions_say(inputs: list[tuple[int, int]]) -> None:
    running = cold(BLOCKS)
    kept = total = 0
    for a, b in inputs:
        running["a"], running["b"] = a, b
        running.cycle()
        kept = a if a > b else kept
        total += max(a, b)
        assert [running[name] for name in ("larger", "kept", "moved", "total")] == [max(a, b), kept, a > b, total]


def test_a_timer_in_a_rung_switches_after_its_time() -> None:
    running = bench(
        tc6(
            pou(
                f"<LD>{rail()}{contact('1', 'start', '0')}"
                + source("2", "T#3s")
                + block("3", "TON", {"IN": "1", "PT": "2"}, "Q ET", 'instanceName="t1"')
                + coil("4", "lamp", "3.Q")
                + "</LD>",
                variables={**BOOLS, "t1": '<derived name="TON"/>'},
            )
        )
    )
    running["start"] = True
    lamp = {}
    for ms in (1_000, 2_000, 3_999, 4_000, 4_001):
        running.host.ms = ms
        running.cycle()
        lamp[ms] = running["lamp"]
    assert lamp == {1_000: False, 2_000: False, 3_999: False, 4_000: True, 4_001: True}


def test_a_jump_passes_over_a_network() -> None:
    jump = '<jump localId="2" label="end"><connectionPointIn><connection refLocalId="1"/></connectionPointIn></jump>'
    running = bench(
        tc6(
            pou(
                f"<LD>{rail()}{contact('1', 'start', '0')}{jump}{coil('3', 'motor', '0')}"
                f'<label localId="4" label="end"/>{coil("5", "lamp", "0")}</LD>',
                variables=BOOLS,
            )
        )
    )
    running["start"] = True
    running.cycle()
    assert (running["motor"], running["lamp"]) == (False, True)
    running["start"] = False
    running.cycle()
    assert running["motor"] is True


def test_variables_of_a_named_list_are_reached_with_its_name_and_without() -> None:
    """TwinCAT and CODESYS V3 write GVL.variable."""
    gvl = (
        '<TcPlcObject><GVL Name="GVL_Belt"><Declaration><![CDATA[VAR_GLOBAL speed : INT := 5; END_VAR\n'
        "VAR_GLOBAL CONSTANT most : INT := 7; END_VAR]]></Declaration></GVL></TcPlcObject>"
    )
    main = (
        '<TcPlcObject><POU Name="MAIN"><Declaration><![CDATA[PROGRAM MAIN VAR x, y : INT; '
        "list : ARRAY[0..GVL_Belt.most] OF INT; END_VAR]]></Declaration><Implementation><ST><![CDATA["
        "GVL_Belt.speed := GVL_Belt.speed + gvl_belt.MOST; x := speed; list[7] := x;]]></ST></Implementation></POU>"
        "</TcPlcObject>"
    )
    files = [SourceFile("GVL_Belt.TcGVL", gvl), SourceFile("MAIN.TcPOU", main)]
    host = PlainHost()
    compiled = compile_project(files, host)
    runtime = Runtime(compiled, host)
    thread = runtime.thread(compiled.program.pous["main"])
    thread.start()
    thread.run(ENOUGH_NS)
    assert [runtime.read(runtime.find(name)) for name in ("speed", "MAIN.x", "MAIN.list[7]")] == [12, 12, 12]


def test_methods_of_a_twincat_file_run() -> None:
    block = (
        '<TcPlcObject><POU Name="FB_Valve"><Declaration><![CDATA[FUNCTION_BLOCK FB_Valve\nVAR_OUTPUT opened : INT; '
        "END_VAR]]></Declaration><Implementation><ST><![CDATA[]]></ST></Implementation>"
        '<Method Name="Open" Id="{1}"><Declaration><![CDATA[METHOD PUBLIC Open : BOOL\nVAR_INPUT\n\tcount : INT;'
        "\nEND_VAR\n]]></Declaration><Implementation><ST><![CDATA[opened := opened + count; // b\nOpen := opened > 3;"
        "]]></ST></Implementation></Method></POU></TcPlcObject>"
    )
    main = (
        '<TcPlcObject><POU Name="MAIN"><Declaration><![CDATA[PROGRAM MAIN VAR v : FB_Valve; a, b : BOOL; END_VAR]]>'
        "</Declaration><Implementation><ST><![CDATA[a := v.Open(2); b := v.Open(count := 2);]]></ST></Implementation>"
        "</POU></TcPlcObject>"
    )
    files = [SourceFile("FB_Valve.TcPOU", block), SourceFile("MAIN.TcPOU", main)]
    host = PlainHost()
    compiled = compile_project(files, host, EDITION_3)
    runtime = Runtime(compiled, host)
    thread = runtime.thread(compiled.program.pous["main"])
    thread.start()
    thread.run(ENOUGH_NS)
    assert [runtime.read(runtime.find(name)) for name in ("MAIN.a", "MAIN.b", "MAIN.v.opened")] == [False, True, 4]


def test_messages_of_all_stages_name_the_file_and_the_line() -> None:
    document = LISTING_57.replace("YVAL + OFFSET;\n    BOTTOM", "YVAL + OFSET;\n    BOTTOM")
    with pytest.raises(CompileError) as caught:
        compile_project([SourceFile("example.xml", document)], PlainHost())
    mistakes = [mistake for mistake in caught.value.mistakes if not mistake.is_note]
    assert [(mistake.file, mistake.line) for mistake in mistakes] == [("example.xml", 21)]
    assert "OFSET is not declared" in mistakes[0].what


WIRE = '<connectionPointIn><connection refLocalId="{}"/></connectionPointIn>'


def step(id: str, name: str, *before: str, attributes: str = "") -> str:
    return f'<step localId="{id}" name="{name}" {attributes}>{"".join(map(WIRE.format, before))}</step>'


def transition(id: str, condition: str, before: str) -> str:
    text = f'<inline name=""><ST><xhtml:p>{condition}</xhtml:p></ST></inline>'
    return f'<transition localId="{id}">{WIRE.format(before)}<condition>{text}</condition></transition>'


def action(id: str, step: str, text: str) -> str:
    body = f"<inline><ST><xhtml:p>{text}</xhtml:p></ST></inline>"
    return f'<actionBlock localId="{id}">{WIRE.format(step)}<action localId="0">{body}</action></actionBlock>'


def test_parallel_branches_of_a_chart_meet_again() -> None:
    chart = (
        step("1", "Idle", "9", attributes='initialStep="true"')
        + transition("2", "start", "1")
        + f'<simultaneousDivergence localId="3">{WIRE.format(2)}</simultaneousDivergence>'
        + step("4", "Heat", "3")
        + step("5", "Stir", "3")
        + action("6", "4", "heated := heated + 1;")
        + action("7", "5", "mixed := mixed + 1;")
        + f'<simultaneousConvergence localId="8">{WIRE.format(4)}{WIRE.format(5)}</simultaneousConvergence>'
        + transition("9", "heated &gt;= 3 AND mixed &gt;= 3", "8")
    )
    running = bench(tc6(pou(f"<SFC>{chart}</SFC>", variables={**BOOLS, "heated": "INT", "mixed": "INT"})))
    running.cycle(2)
    assert (running["heated"], running["mixed"]) == (0, 0)
    running["start"] = True
    running.cycle()
    running["start"] = False
    running.cycle(10)
    assert (running["heated"], running["mixed"]) == (3, 3)


def test_the_chart_inside_of_a_macro_step_runs_in_its_place() -> None:
    inside = (
        step("1", "Heat")
        + action("2", "1", "heated := heated + 1;")
        + transition("3", "heated &gt;= 3", "1")
        + step("4", "Stir", "3")
        + action("5", "4", "mixed := mixed + 1;")
    )
    chart = (
        step("1", "Idle", "4", attributes='initialStep="true"')
        + transition("2", "start", "1")
        + f'<macroStep localId="3" name="Cook">{WIRE.format(2)}<body><SFC>{inside}</SFC></body></macroStep>'
        + transition("4", "mixed &gt;= 2", "3")
    )
    running = bench(tc6(pou(f"<SFC>{chart}</SFC>", variables={**BOOLS, "heated": "INT", "mixed": "INT"})))
    running["start"] = True
    seen = []
    for _ in range(8):
        running.cycle()
        running["start"] = False
        seen.append((running["heated"], running["mixed"]))
    assert sorted(seen) == seen
    assert (3, 0) in seen
    assert seen[-1] == (3, 2)


COUNTER = """<pou name="{name}" pouType="functionBlock"><interface>
<inputVars><variable name="Reset"><type><BOOL/></type></variable></inputVars>
<outputVars><variable name="Out"><type><INT/></type></variable></outputVars>
<localVars><variable name="Cnt"><type><INT/></type></variable></localVars></interface>{more}<body>{body}</body></pou>"""


def _drawn_counter(language: str) -> str:
    """Cnt := SEL(Reset, Cnt + 1, 17), with Cnt in the loop, and Out behind it."""
    reset = contact("9", "Reset", "8") if language == "LD" else source("9", "Reset")
    rail_ = (
        '<leftPowerRail localId="8"><connectionPointOut formalParameter=""/></leftPowerRail>'
        if language == "LD"
        else ""
    )
    loop = (
        '<inOutVariable localId="3" negatedOut="false" negatedIn="false"><connectionPointIn>'
        '<connection refLocalId="7" formalParameter="OUT"/></connectionPointIn><connectionPointOut/>'
        "<expression>Cnt</expression></inOutVariable>"
    )
    blocks = block("4", "ADD", {"IN1": "6", "IN2": "3"}) + block("7", "SEL", {"G": "9", "IN0": "4.OUT", "IN1": "5"})
    inside = sink("2", "Out", "3") + loop + blocks + source("5", "17") + source("6", "1") + rail_ + reset
    return f"<{language}>{inside}</{language}>"


BODIES = {
    "ST": "<ST><xhtml:p><![CDATA[IF Reset THEN Cnt := 17; ELSE Cnt := Cnt + 1; END_IF;\nOut := Cnt;]]></xhtml:p></ST>",
    "IL": "<IL><xhtml:p><![CDATA[LD Reset\nJMPC ToReset\n\n(* count *)\nLD Cnt\nADD 1\nJMP Save\n\nToReset:\n"
    "LD 17\n\nSave:\nST Cnt\nST Out\n]]></xhtml:p></IL>",
    "FBD": _drawn_counter("FBD"),
    "LD": _drawn_counter("LD"),
}


@settings(deadline=None)
@given(st.lists(st.booleans(), max_size=10))
def test_the_same_counter_counts_the_same_in_every_language(resets: list[bool]) -> None:
    """A project with a function block in each language, as the editors' first example has it."""
    blocks = "".join(COUNTER.format(name=f"Counter{name}", body=body, more="") for name, body in BODIES.items())
    instances = {f"c{name}": f'<derived name="Counter{name}"/>' for name in BODIES}
    calls = "".join(f"c{name}(Reset := reset); " for name in BODIES)
    text = tc6(pou(f"<ST>{calls}</ST>", variables={"reset": "BOOL", **instances}).replace("<pous>", f"<pous>{blocks}"))
    running = cold(text)
    expected = 0
    for reset in resets:
        running["reset"] = reset
        running.cycle()
        expected = 17 if reset else expected + 1
        assert {name: running[f"c{name}.Out"] for name in BODIES} == dict.fromkeys(BODIES, expected)


OBJECTS = """
<addData><data name="http://www.3s-software.com/plcopenxml/method" handleUnknown="implementation">
<Method name="Fill" ObjectId="3f4c6c0e-0000-0000-0000-000000000001">
<interface><returnType><BOOL/></returnType>
<inputVars><variable name="by_mm"><type><INT/></type></variable></inputVars></interface>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">Height := Height + by_mm;
Fill := Height &gt;= limit;</xhtml></ST></body><addData/></Method></data>
<data name="http://www.3s-software.com/plcopenxml/method" handleUnknown="implementation">
<Method name="Is_Low"><interface><returnType><BOOL/></returnType></interface>
<body><LD>{ladder}</LD></body></Method></data>
<data name="http://www.3s-software.com/plcopenxml/property" handleUnknown="implementation">
<Property name="Height"><interface><returnType><INT/></returnType></interface>
<GetAccessor><interface/><body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">Height := level;</xhtml></ST></body>
</GetAccessor><SetAccessor><interface/>
<body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">level := MIN(Height, limit);</xhtml></ST></body></SetAccessor>
</Property></data></addData>
"""
BLOCK = "functionBlock"
INHERITANCE = (
    '<addData><data name="http://www.3s-software.com/plcopenxml/pouinheritance" handleUnknown="implementation">'
    "<Inheritance><Extends>Tank</Extends></Inheritance></data></addData>"
)


def test_methods_properties_and_inheritance_of_an_export_of_codesys_run() -> None:
    ladder = rail() + contact("1", "empty", "0") + coil("2", "Is_Low", "1")
    tank = named("Tank", pou("<ST/>", variables={"level": "INT", "limit": "INT", "empty": "BOOL"}, kind=BLOCK))
    tank = tank.replace("localVars", "inputVars").replace("</pou>", OBJECTS.format(ladder=ladder) + "</pou>")
    large = named("Large", pou("<ST/>", kind=BLOCK)).replace("</interface>", f"{INHERITANCE}</interface>")
    body = "tank.limit := 50; tank.empty := TRUE; full := tank.Fill(30); low := tank.Is_Low(); height := tank.Height;"
    variables = {"tank": '<derived name="Large"/>', "full": "BOOL", "low": "BOOL", "height": "INT"}
    main = named("PLC_PRG", pou(f"<ST><xhtml:p>{body}</xhtml:p></ST>", variables=variables))
    running = IecBench(tc6(tank + large + main), CODESYS)
    running.cycle()
    assert (running["full"], running["height"], running["low"]) == (False, 30, True)
    running.cycle()
    assert (running["full"], running["height"]) == (True, 50)


def named(name: str, document: str) -> str:
    return document.replace('<pou name="P"', f'<pou name="{name}"')
