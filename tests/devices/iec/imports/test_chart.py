"""Sequential function charts of PLCopen XML (manual 1741 to 1842): steps, transitions, branches, actions."""

import pytest
from exchange_documents import block, contact, messages, only_pou, point, pou, rail, read, source, st, tc6
from iec_program import IecBench

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3

VARIABLES = {"a": "BOOL", "b": "BOOL", "n": "INT", "lamp": "BOOL"}


def step(id: str, name: str, *wires: str, attributes: str = "", more: str = "") -> str:
    return (
        f'<step localId="{id}" name="{name}" {attributes}>{point(*wires)}<connectionPointOut formalParameter="sfc"/>'
        f'<connectionPointOutAction formalParameter="a"/>{more}</step>'
    )


def start(id: str = "1", name: str = "Start", *wires: str) -> str:
    return step(id, name, *wires, attributes='initialStep="true"')


def inline(text: str) -> str:
    return f'<inline name=""><ST><xhtml:p><![CDATA[{text}]]></xhtml:p></ST></inline>'


def transition(id: str, condition: str, *wires: str, attributes: str = "") -> str:
    given = condition if condition.startswith("<") else inline(condition)
    return (
        f'<transition localId="{id}" {attributes}>{point(*wires)}<connectionPointOut/>'
        f"<condition>{given}</condition></transition>"
    )


def jump(id: str, target: str, *wires: str) -> str:
    return f'<jumpStep localId="{id}" targetName="{target}">{point(*wires)}</jumpStep>'


def branch(kind: str, id: str, *wires: str) -> str:
    """A divergence or convergence, with an input point for each wire."""
    return f'<{kind} localId="{id}">{"".join(map(point, wires))}<connectionPointOut formalParameter=""/></{kind}>'


def action(inside: str, attributes: str = "") -> str:
    """An action block at step 1 with one action."""
    found = f'<action localId="0" {attributes}>{inside}</action>'
    return f'<actionBlock localId="8">{point("1")}{found}</actionBlock>'


def chart(*elements: str, more: str = "") -> str:
    return tc6(pou(f"<SFC>{''.join(elements)}</SFC>", variables=VARIABLES, more=more))


def body_of(text: str) -> tree.SfcBody:
    body = only_pou(text).body
    assert isinstance(body, tree.SfcBody)
    return body


def lines(body: tree.SfcBody) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
    return [(found.sources, found.targets) for found in body.transitions]


def expression(text: str) -> tree.Expression:
    (assignment,) = st(f"x := {text};")
    assert isinstance(assignment, tree.Assign)
    return assignment.value


def test_a_chain_of_steps_with_a_jump_back() -> None:
    body = body_of(
        chart(
            start(),
            transition("2", "a", "1"),
            step("3", "Fill", "2"),
            transition("4", "n > 3", "3"),
            jump("5", "Start", "4"),
        )
    )
    assert [(found.name, found.is_initial) for found in body.steps] == [("Start", True), ("Fill", False)]
    assert body.transitions == (
        tree.Transition(("Start",), ("Fill",), expression("a")),
        tree.Transition(("Fill",), ("Start",), expression("n > 3")),
    )


def test_a_line_back_to_the_initial_step_needs_no_jump() -> None:
    body = body_of(
        chart(start("1", "Start", "4"), transition("2", "a", "1"), step("3", "Fill", "2"), transition("4", "b", "3"))
    )
    assert lines(body) == [(("Start",), ("Fill",)), (("Fill",), ("Start",))]


def test_a_selection_tests_by_priority_then_from_left_to_right() -> None:
    body = body_of(
        chart(
            start(),
            branch("selectionDivergence", "2", "1"),
            transition("3", "a", "2").replace("<connectionPointIn>", '<position x="90" y="5"/><connectionPointIn>', 1),
            transition("4", "b", "2").replace("<connectionPointIn>", '<position x="10" y="5"/><connectionPointIn>', 1),
            transition("5", "lamp", "2", attributes='priority="1"'),
            step("6", "A", "3"),
            step("7", "B", "4"),
            step("8", "C", "5"),
            transition("9", "a", "6"),
            transition("10", "b", "7"),
            transition("11", "lamp", "8"),
            branch("selectionConvergence", "12", "9", "10", "11"),
            jump("13", "Start", "12"),
        )
    )
    assert [found.targets for found in body.transitions if found.sources == ("Start",)] == [("C",), ("B",), ("A",)]
    assert {found.sources for found in body.transitions if found.targets == ("Start",)} == {("A",), ("B",), ("C",)}


def test_parallel_branches_begin_and_end_together() -> None:
    body = body_of(
        chart(
            start(),
            transition("2", "a", "1"),
            f'<simultaneousDivergence localId="3" name="Fork">{point("2")}<connectionPointOut formalParameter="0"/>'
            '<connectionPointOut formalParameter="1"/></simultaneousDivergence>',
            step("4", "Heat", "3.0"),
            step("5", "Stir", "3.1"),
            branch("simultaneousConvergence", "6", "4.sfc", "5.sfc"),
            transition("7", "b", "6"),
            jump("8", "Start", "7"),
        )
    )
    assert lines(body) == [(("Start",), ("Heat", "Stir")), (("Heat", "Stir"), ("Start",))]


def test_a_jump_may_lead_to_parallel_branches() -> None:
    body = body_of(
        chart(
            start(),
            transition("2", "a", "1"),
            f'<simultaneousDivergence localId="3" name="Fork">{point("2")}</simultaneousDivergence>',
            step("4", "Heat", "3"),
            step("5", "Stir", "3"),
            f'<simultaneousConvergence localId="6">{point("4")}{point("5")}</simultaneousConvergence>',
            transition("7", "b", "6"),
            jump("8", "fork", "7"),
        )
    )
    assert lines(body)[-1] == (("Heat", "Stir"), ("Heat", "Stir"))


@pytest.mark.parametrize("text", ["a AND b", ":= a AND b;", "T1 := a AND b;", "\n a AND\n b ;"])
def test_conditions_in_text_have_several_forms(text: str) -> None:
    body = body_of(chart(start(), transition("2", text, "1"), jump("3", "Start", "2")))
    assert body.transitions[0].condition == expression("a AND b")


def test_a_condition_may_refer_to_a_transition_of_the_pou_or_a_variable() -> None:
    body = "<body><ST><xhtml:p>:= NOT a;</xhtml:p></ST></body>"
    named = f'<transitions><transition name="Go">{body}</transition></transitions>'
    reference = transition("2", '<reference name="Go"/>', "1")
    plain = transition("4", '<reference name="b"/>', "3")
    drawn = chart(start(), reference, step("3", "S", "2"), plain, jump("5", "Start", "4"), more=named)
    assert [found.condition for found in body_of(drawn).transitions] == [expression("NOT a"), expression("b")]


def test_a_condition_may_be_a_list() -> None:
    list_ = '<inline name=""><IL><xhtml:p>LD a\nANDN b\nOR lamp</xhtml:p></IL></inline>'
    body = body_of(chart(start(), transition("2", list_, "1"), jump("3", "Start", "2")))
    assert body.transitions[0].condition == expression("(a AND NOT b) OR lamp")


def test_a_condition_may_be_wired_from_contacts() -> None:
    contact = f'<contact localId="9" negated="true">{point("0")}<connectionPointOut/><variable>a</variable></contact>'
    wired = transition("2", point("9"), "1")
    body = body_of(chart(rail(), contact, start(), wired, jump("3", "Start", "2")))
    assert body.transitions[0].condition == expression("NOT a")


def test_a_condition_may_be_wired_from_a_variable_as_some_tools_write_every_condition() -> None:
    body = body_of(chart(start(), source("9", "n = 5"), transition("2", point("9"), "1"), jump("3", "Start", "2")))
    assert body.transitions[0].condition == expression("n = 5")


def test_a_condition_may_be_a_network_with_one_result() -> None:
    network = (
        f'<inline name=""><LD>{rail()}<contact localId="1">{point("0")}<variable>a</variable></contact>'
        f'<coil localId="2">{point("1")}<variable>T1</variable></coil></LD></inline>'
    )
    body = body_of(chart(start(), transition("2", network, "1"), jump("3", "Start", "2")))
    assert body.transitions[0].condition == expression("a")


def test_a_negated_condition() -> None:
    negated = transition("2", "a", "1").replace("<condition>", '<condition negated="true">')
    assert body_of(chart(start(), negated, jump("3", "Start", "2"))).transitions[0].condition == expression("NOT a")


@pytest.mark.parametrize("qualifier", ["N", "R", "S", "P", "P0", "P1"])
def test_actions_are_used_with_their_qualifiers(qualifier: str) -> None:
    actions = (
        f'<actionBlock localId="8">{point("1.a")}<action localId="0" qualifier="{qualifier}"><reference name="lamp"/>'
        "</action></actionBlock>"
    )
    body = body_of(chart(start(), actions, transition("2", "a", "1"), jump("3", "Start", "2")))
    assert body.steps[0].uses == (tree.ActionUse("lamp", qualifier),)


@pytest.mark.parametrize("qualifier", ["L", "D", "SD", "DS", "SL"])
def test_timed_actions_have_a_duration(qualifier: str) -> None:
    actions = (
        f'<actionBlock localId="8">{point("1")}<action localId="0" qualifier="{qualifier}" duration="T#3s">'
        '<reference name="lamp"/></action></actionBlock>'
    )
    drawn = chart(start(), actions, transition("2", "a", "1"), jump("3", "Start", "2"))
    assert body_of(drawn).steps[0].uses == (tree.ActionUse("lamp", qualifier, expression("T#3s")),)
    (message,) = messages(drawn.replace(' duration="T#3s"', ""))
    assert f"The qualifier {qualifier} needs a time; expected a duration" in message


def test_a_qualifier_without_meaning_is_refused() -> None:
    actions = action('<reference name="lamp"/>', 'qualifier="DL" duration="T#1s"')
    (message,) = messages(chart(start(), actions, transition("2", "a", "1"), jump("3", "Start", "2")))
    assert "step Start: The qualifier DL is not known" in message


def test_actions_in_the_chart_become_actions_of_the_pou() -> None:
    actions = (
        f'<actionBlock localId="8">{point("1")}<action localId="0">{inline("n := n + 1;")}</action>'
        f'<action localId="0" qualifier="P1">{inline("n := 0;")}</action></actionBlock>'
    ).replace(' name=""', "")
    found = only_pou(chart(start(), actions, transition("2", "a", "1"), jump("3", "Start", "2")))
    assert isinstance(found.body, tree.SfcBody)
    assert [(use.name, use.qualifier) for use in found.body.steps[0].uses] == [
        ("Start_action1", "N"),
        ("Start_action2", "P1"),
    ]
    assert found.actions == (
        tree.Action("Start_action1", tree.StBody(st("n := n + 1;"))),
        tree.Action("Start_action2", tree.StBody(st("n := 0;"))),
    )


def test_actions_of_the_pou_are_elements_of_their_own() -> None:
    more = '<actions><action name="Count"><body><ST><xhtml:p>n := n + 1;</xhtml:p></ST></body></action></actions>'
    actions = (
        f'<actionBlock localId="8">{point("1")}<action localId="0"><reference name="Count"/></action></actionBlock>'
    )
    found = only_pou(chart(start(), actions, transition("2", "a", "1"), jump("3", "Start", "2"), more=more))
    assert found.actions == (tree.Action("Count", tree.StBody(st("n := n + 1;"))),)


def test_a_variable_at_a_step_is_on_while_the_step_is_active() -> None:
    wired = f'<outVariable localId="8">{point("1.a")}<expression>lamp</expression></outVariable>'
    body = body_of(chart(start(), wired, transition("2", "a", "1"), jump("3", "Start", "2")))
    assert body.steps[0].uses == (tree.ActionUse("lamp", "N"),)


def test_entry_active_and_exit_actions_of_todays_tools() -> None:
    more = (
        '<addData><data name="http://www.3s-software.com/plcopenxml/sfc/element" handleUnknown="implementation">'
        '<attributes xmlns=""><attribute guid="a6b08bd8-b696-47e3-9cbf-7408b61c9ff8">Begin</attribute>'
        '<attribute guid="700a583f-b4d4-43e4-8c14-629c7cd3bec8">Work</attribute>'
        '<attribute guid="a2621e18-7de3-4ea6-ae6d-89e9e0b7befd">End</attribute>'
        '<attribute guid="01580b27-6378-448b-8ecb-0e4b795b58d6">FALSE</attribute></attributes></data></addData>'
    )
    drawn = chart(start().replace("</step>", f"{more}</step>"), transition("2", "a", "1"), jump("3", "Start", "2"))
    (found,) = body_of(drawn).steps
    assert (found.entry, found.active, found.exit) == tuple(
        tree.StBody((tree.CallStatement(tree.Call(tree.Name(name), ())),)) for name in ("Begin", "Work", "End")
    )


@pytest.mark.parametrize(
    ("drawn", "expected"),
    [
        (chart(step("1", "S"), transition("2", "a", "1"), jump("3", "S", "2")), "The chart has no initial step"),
        (chart(transition("2", "a")), "The chart has no step"),
        (chart(start(), transition("2", "a", "1"), jump("3", "Nowhere", "2")), "The jump leads to Nowhere"),
        (chart(start(), transition("2", "a", "1")), "The transition leads to no step"),
        (chart(start(), transition("2", "a"), jump("3", "Start", "2")), "The transition follows no step"),
        (chart(start(), step("2", "T", "1")), "The step T (element 2) follows the step Start (element 1)"),
        (chart(start(), '<macroStep localId="7" name="M"/>'), "The macro step M has 0 steps to begin with"),
        (chart(start(), transition("2", "<x/>", "1"), jump("3", "Start", "2")), "The transition has no condition"),
        (chart(start(), transition("2", "a :=", "1"), jump("3", "Start", "2")), "transition 2"),
    ],
)
def test_what_is_wrong_in_a_chart_is_named(drawn: str, expected: str) -> None:
    assert any(expected in message for message in messages(drawn)), read(drawn)[1]


def running(*elements: str, **variables: str) -> IecBench:
    return IecBench(tc6(pou(f"<SFC>{''.join(elements)}</SFC>", variables=variables)), EDITION_3, main="P")


def test_a_timer_in_front_of_a_transition_runs_while_its_step_is_active() -> None:
    """The step is left in the cycle in which the 50 ms are over, and not before."""
    ton = block("9", "TON", {"IN": "8", "PT": "7"}, "Q ET", 'instanceName="t"')
    bench = running(
        source("8", "a"), source("7", "T#50ms"), ton, start(), transition("2", point("9.Q"), "1"),
        step("3", "Next", "2"), transition("4", "FALSE", "3"), jump("5", "Start", "4"),
        a="BOOL", t='<derived name="TON"/>',
    )  # fmt: skip
    active = []
    for ms in (0, 20, 40, 60, 69, 70, 80):
        bench.host.ms, bench["a"] = ms, ms >= 20
        bench.cycle()
        active.append(bench["Next.x"])
    assert active == [False, False, False, False, False, True, True]


def test_alternatives_of_a_step_share_the_blocks_in_front_of_them() -> None:
    """The edge of `a` is seen by both transitions; the second one fires, because only it has b."""
    edge = block("9", "R_TRIG", {"CLK": "8"}, "Q", 'instanceName="t"')
    both = block("11", "AND", {"IN1": "9.Q", "IN2": "10"})
    bench = running(
        source("8", "a"), edge, source("10", "c"), both, start(),
        transition("2", point("11.OUT"), "1", attributes='priority="1"'), step("3", "First", "2"),
        transition("4", point("9.Q"), "1", attributes='priority="2"'), step("5", "Second", "4"),
        transition("6", "FALSE", "3", "5"), jump("7", "Start", "6"),
        a="BOOL", c="BOOL", t='<derived name="R_TRIG"/>',
    )  # fmt: skip
    bench.cycle()
    bench["a"] = True
    bench.cycle()
    assert (bench["First.x"], bench["Second.x"]) == (False, True)


def test_an_edge_in_front_of_a_transition() -> None:
    edge = contact("9", "a", "0", attributes='edge="rising"')
    bench = running(
        rail(), edge, start(),
        transition("2", point("9"), "1"), step("3", "Next", "2"),
        transition("4", "NOT a", "3"), jump("5", "Start", "4"), a="BOOL",
    )  # fmt: skip
    seen = []
    for value in (False, True, True, False, False, True):
        bench["a"] = value
        bench.cycle()
        seen.append(bench["Next.x"])
    assert seen == [False, True, True, False, False, True]


def test_a_block_behind_parallel_steps_runs_when_all_of_them_are_active() -> None:
    """The timer begins with the later step."""
    ton = block("9", "TON", {"IN": "8", "PT": "7"}, "Q ET", 'instanceName="t"')
    bench = running(
        source("8", "TRUE"), source("7", "T#50ms"), ton, start(), transition("2", "TRUE", "1"),
        branch("simultaneousDivergence", "3", "2"), step("4", "Left", "3"), step("5", "Right", "3"),
        transition("15", "a", "5"), step("16", "Later", "15"),
        branch("simultaneousConvergence", "10", "4", "16"), transition("11", point("9.Q"), "10"),
        step("12", "End", "11"), transition("13", "FALSE", "12"), jump("14", "Start", "13"),
        a="BOOL", t='<derived name="TON"/>',
    )  # fmt: skip
    ended = []
    for ms in (0, 20, 100, 120, 140, 160, 180, 200):
        bench.host.ms, bench["a"] = ms, ms >= 100
        bench.cycle()
        ended.append(bench["End.x"])
    assert ended == [False] * 6 + [True] * 2


def test_an_empty_chart_does_nothing() -> None:
    assert only_pou(chart()).body == tree.StBody(())
