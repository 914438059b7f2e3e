"""A whole project in the form of the free editors: POUs in three languages, and a configuration, in one file."""

from exchange_documents import block, read, sink, source, tc6
from iec_program import IecBench

from fieldrig_devices.iec import tree

WIRE = '<connectionPointIn><connection refLocalId="{}"/></connectionPointIn>'


def text(content: str) -> str:
    return f"<ST><xhtml:p><![CDATA[{content}]]></xhtml:p></ST>"


def declared(**types: str) -> str:
    return "".join(
        f'<variable name="{name}"><type>{of if of.startswith("<") else f"<{of}/>"}</type></variable>'
        for name, of in types.items()
    )


def block_type(name: str, body: str) -> str:
    return (
        f'<pou name="{name}" pouType="functionBlock"><interface><inputVars>{declared(Reset="BOOL")}</inputVars>'
        f"<localVars>{declared(Cnt='INT')}</localVars><outputVars>{declared(OUT='INT')}</outputVars>"
        f'<externalVars constant="true">{declared(ResetValue="INT")}</externalVars></interface><actions/>'
        f"<body>{body}</body></pou>"
    )


def transition(id: str, condition: str, before: str) -> str:
    inside = f'<inline name="">{text(condition)}</inline>'
    return f'<transition localId="{id}">{WIRE.format(before)}<condition>{inside}</condition></transition>'


def step(id: str, name: str, before: str, *actions: str) -> str:
    """A step with an action block, whose actions all have the identifier 0 in these editors."""
    used = "".join(f'<action localId="0"><inline>{text(action)}</inline></action>' for action in actions)
    return (
        f'<step localId="{id}" name="{name}" initialStep="false">{WIRE.format(before)}</step>'
        f'<actionBlock localId="{id}0">{WIRE.format(id)}{used}</actionBlock>'
    )


CHART = (
    '<SFC><step localId="1" name="Start" initialStep="true"><connectionPointOut formalParameter=""/></step>'
    f'<selectionDivergence localId="2">{WIRE.format(1)}</selectionDivergence>'
    + transition("3", "Reset", "2")
    + transition("4", "NOT Reset", "2")
    + step("5", "ResetCounter", "3", "Cnt := ResetValue;", "OUT := Cnt;")
    + step("7", "Count", "4", "Cnt := Cnt + 1;", "OUT := Cnt;")
    + transition("13", "Reset", "7")
    + transition("14", "NOT Reset", "5")
    + f'<selectionConvergence localId="10">{WIRE.format(13)}{WIRE.format(14)}</selectionConvergence>'
    f'<jumpStep localId="12" targetName="Start">{WIRE.format(10)}</jumpStep></SFC>'
)
AVERAGE = (
    '<pou name="AverageVal" pouType="function"><interface><returnType><REAL/></returnType>'
    f"<inputVars>{declared(One='INT', Other='INT')}</inputVars></interface>"
    f"<body>{text('AverageVal := INT_TO_REAL(One + Other) / 2.0;')}</body></pou>"
)


def through(id: str, wire: str, variable: str) -> str:
    return (
        f'<inOutVariable localId="{id}" negatedOut="false" negatedIn="false"><connectionPointIn>'
        f'<connection refLocalId="{wire}" formalParameter="OUT"/></connectionPointIn><connectionPointOut/>'
        f"<expression>{variable}</expression></inOutVariable>"
    )


PROGRAM = (
    '<pou name="plc_prg" pouType="program"><interface>'
    f"<inputVars>{declared(Reset='BOOL')}</inputVars><outputVars>{declared(Cnt1='INT', Cnt2='INT')}</outputVars>"
    "<localVars>"
    + declared(A='<derived name="CounterST"/>', B='<derived name="CounterSFC"/>', Mean="REAL")
    + "</localVars></interface><body><FBD>"
    + block("1", "CounterST", {"Reset": "2"}, "OUT", 'instanceName="A" executionOrderId="0"')
    + source("2", "Reset", 'executionOrderId="0"')
    + block("4", "CounterSFC", {"Reset": "2"}, "OUT", 'instanceName="B" executionOrderId="0"')
    + block("17", "AverageVal", {"One": "3", "Other": "5"})
    + sink("18", "Mean", "17.OUT")
    + through("3", "1", "Cnt1")
    + through("5", "4", "Cnt2")
    + "</FBD></body></pou>"
)
CONFIGURATION = (
    '<configuration name="config"><resource name="resource1"><task name="plc_task" priority="1" interval="T#100ms">'
    '<pouInstance name="plc_task_instance" typeName="plc_prg"/></task></resource><globalVars constant="true">'
    '<variable name="ResetValue"><type><INT/></type><initialValue><simpleValue value="17"/></initialValue></variable>'
    "</globalVars></configuration>"
)
IN_ST = "IF Reset THEN\n  Cnt := ResetValue;\nELSE\n  Cnt := Cnt + 1;\nEND_IF;\n\nOut := Cnt;"
PROJECT = tc6(
    "<dataTypes/><pous>"
    + block_type("CounterST", text(IN_ST))
    + block_type("CounterSFC", CHART)
    + AVERAGE
    + PROGRAM
    + "</pous>",
    instances=CONFIGURATION,
)


def test_the_project_runs_in_its_own_task() -> None:
    running = IecBench(PROJECT, main="plc_prg")
    (task,) = running.compiled.tasks
    assert (task.name, task.priority, task.interval_ms) == ("plc_task", 1, 100)


def test_counters_in_text_and_in_a_chart_count() -> None:
    """The chart needs a cycle for the step from Start to Count, and one each for the way back over Start."""
    running = IecBench(PROJECT, main="plc_prg")
    seen = []
    for cycle in range(8):
        running["Reset"] = cycle >= 4
        running.cycle()
        seen.append((running["Cnt1"], running["Cnt2"], running["Mean"]))
    assert seen[:4] == [(1, 0, 0.5), (2, 1, 1.5), (3, 2, 2.5), (4, 3, 3.5)]
    assert seen[4:] == [(17, 4, 10.5), (17, 4, 10.5), (17, 17, 17.0), (17, 17, 17.0)]


def test_nothing_of_the_project_is_left_out() -> None:
    unit, mistakes = read(PROJECT)
    assert mistakes == []
    assert [type(declaration) for declaration in unit.declarations] == [
        tree.Variables,
        *[tree.Pou] * 4,
        tree.Configuration,
    ]
