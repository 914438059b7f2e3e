"""Function block diagram of PLCopen XML: operators, functions, instances, EN and ENO, and loops."""

import pytest
from exchange_documents import block, messages, pou, read, sink, source, st, statements, tc6

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.imports.networks.functions import OPERATORS

VARIABLES = {"a": "INT", "b": "INT", "c": "INT", "x": "BOOL", "y": "BOOL", "t1": '<derived name="TON"/>', "et": "TIME"}


def fbd(*elements: str, **variables: str) -> str:
    return tc6(pou(f"<FBD>{''.join(elements)}</FBD>", variables={**VARIABLES, **variables}))


def test_the_manuals_figure_of_a_network_becomes_one_assignment() -> None:
    drawn = fbd(
        source("1", "a"),
        source("2", "b"),
        block("3", "ADD", {"IN1": "1", "IN2": "2"}),
        source("4", "3"),
        block("5", "MUL", {"IN1": "3.OUT", "IN2": "4"}),
        sink("6", "c", "5.OUT"),
    )
    assert statements(drawn) == st("c := (a + b) * 3;")


@pytest.mark.parametrize("name", [name for name in OPERATORS if name.isalpha()])
def test_operators_are_those_of_the_language(name: str) -> None:
    drawn = fbd(
        source("1", "a"), source("2", "b"), block("3", name.upper(), {"IN1": "1", "IN2": "2"}), sink("4", "c", "3")
    )
    assert statements(drawn) == st(f"c := a {OPERATORS[name]} b;")


def test_operators_take_any_number_of_inputs() -> None:
    inputs = source("1", "a"), source("2", "b"), source("3", "c")
    pins = {"IN1": "1", "IN2": "2", "IN3": "3"}
    assert statements(fbd(*inputs, block("4", "ADD", pins), sink("5", "c", "4.OUT"))) == st("c := a + b + c;")
    assert statements(fbd(*inputs, block("4", "GT", pins), sink("5", "x", "4.OUT"))) == st("x := a > b AND b > c;")


def test_not_and_move_have_one_input() -> None:
    assert statements(fbd(source("1", "x"), block("2", "NOT", {"IN": "1"}), sink("3", "y", "2"))) == st("y := NOT x;")
    assert statements(fbd(source("1", "a"), block("2", "MOVE", {"IN": "1"}), sink("3", "b", "2"))) == st("b := a;")


def test_an_operator_with_an_open_input_is_refused() -> None:
    (message,) = messages(fbd(source("1", "a"), block("2", "ADD", {"IN1": "1", "IN2": ""}), sink("3", "b", "2.OUT")))
    assert "An input of the block ADD (element 2) is not connected" in message


def test_standard_functions_are_called_with_their_inputs_in_order() -> None:
    pins = {"G": "1", "IN0": "2", "IN1": "3"}
    drawn = fbd(source("1", "x"), source("2", "a"), source("3", "17"), block("4", "SEL", pins), sink("5", "c", "4.OUT"))
    assert statements(drawn) == st("c := SEL(x, a, 17);")


def test_pins_and_variables_are_negated() -> None:
    drawn = fbd(
        source("1", "x", 'negated="true"'),
        source("2", "y"),
        block("3", "AND", {"IN1": "1", 'IN2 negated="true"': "2"}),
        sink("4", "x", "3.OUT", attributes='negated="true"'),
    )
    assert statements(drawn) == st("x := NOT (NOT x AND NOT y);")


def test_an_edge_at_a_pin_is_remembered() -> None:
    drawn = fbd(source("1", "x"), block("2", "MOVE", {'IN edge="rising"': "1"}), sink("3", "y", "2.OUT"))
    assert statements(drawn) == st("Net1_Edge2 := x AND NOT Net1_Before1; Net1_Before1 := x; y := Net1_Edge2;")


def test_an_instance_is_called_before_its_outputs_are_used() -> None:
    drawn = fbd(
        sink("5", "et", "3.ET"),
        sink("4", "y", "3.Q"),
        source("1", "x"),
        source("2", "T#5s"),
        block("3", "TON", {"IN": "1", "PT": "2"}, "Q ET", 'instanceName="t1"'),
    )
    assert statements(drawn) == st("t1(IN := x, PT := T#5s); et := t1.ET; y := t1.Q;")


def test_open_inputs_of_an_instance_keep_their_values() -> None:
    drawn = fbd(source("1", "x"), block("2", "TON", {"IN": "1", "PT": ""}, "Q", 'instanceName="t1"'))
    assert statements(drawn) == st("t1(IN := x);")


def test_an_instance_that_feeds_itself_uses_the_previous_cycle() -> None:
    drawn = fbd(
        block("1", "NOT", {"IN": "2.Q"}),
        source("9", "T#1s"),
        block("2", "TON", {"IN": "1.OUT", "PT": "9"}, "Q", 'instanceName="t1"'),
        sink("3", "y", "2.Q"),
    )
    assert statements(drawn) == st("t1(IN := NOT t1.Q, PT := T#1s); y := t1.Q;")


def test_a_loop_through_a_variable_uses_its_value() -> None:
    through = (
        '<inOutVariable localId="3"><connectionPointIn><connection refLocalId="2" formalParameter="OUT"/>'
        "</connectionPointIn><connectionPointOut/><expression>c</expression></inOutVariable>"
    )
    drawn = fbd(source("1", "1"), block("2", "ADD", {"IN1": "1", "IN2": "3"}), through, sink("4", "b", "3"))
    assert statements(drawn) == st("c := 1 + c; b := c;")


def test_a_loop_without_a_variable_keeps_its_value_in_a_hidden_one() -> None:
    drawn = fbd(source("1", "a"), block("2", "ADD", {"IN1": "1", "IN2": "2.OUT"}), sink("3", "b", "2.OUT"))
    assert statements(drawn) == st("Net1_Result1 := a + Net1_Result1; b := Net1_Result1;")


def test_a_result_for_two_consumers_is_calculated_once() -> None:
    drawn = fbd(source("1", "a"), block("2", "ABS", {"IN": "1"}), sink("3", "b", "2.OUT"), sink("4", "c", "2.OUT"))
    assert statements(drawn) == st("Net1_Result1 := ABS(a); b := Net1_Result1; c := Net1_Result1;")


def test_a_result_of_unknown_type_asks_for_a_variable() -> None:
    drawn = fbd(source("1", "g.w"), block("2", "MYSTERY", {"IN": "1"}), sink("3", "u", "2"), sink("4", "v", "2"))
    (message, *_) = messages(drawn)
    assert "The type of output OUT of the block MYSTERY (element 2) is unknown, and its value is kept" in message
    assert "hint: Connect the output to a variable" in message


def test_a_block_with_en_runs_only_while_en_is_true() -> None:
    drawn = fbd(
        source("1", "x"),
        source("2", "a"),
        source("3", "b"),
        block("4", "ADD", {"EN": "1", "IN1": "2", "IN2": "3"}, "ENO OUT"),
        sink("5", "c", "4.OUT"),
        sink("6", "y", "4.ENO"),
    )
    assert statements(drawn) == st("Net1_Enable1 := x; IF Net1_Enable1 THEN c := a + b; END_IF y := Net1_Enable1;")


def test_en_that_is_always_true_needs_no_condition() -> None:
    drawn = fbd(
        source("1", "TRUE"),
        source("2", "a"),
        block("3", "MOVE", {"EN": "1", "IN": "2"}, "ENO OUT"),
        sink("4", "c", "3.OUT"),
        sink("5", "y", "3.ENO"),
    )
    assert statements(drawn) == st("c := a; y := TRUE;")


def test_an_instance_with_en_is_called_in_a_condition() -> None:
    drawn = fbd(
        source("1", "x"),
        source("2", "y"),
        block("3", "TON", {"EN": "1", "IN": "2"}, "ENO Q", 'instanceName="t1"'),
        sink("4", "y", "3.Q"),
    )
    assert statements(drawn) == st("Net1_Enable1 := x; IF Net1_Enable1 THEN t1(IN := y); END_IF y := t1.Q;")


CHECKED = (
    '<pou name="CHECKED" pouType="function"><interface><returnType><INT/></returnType><inputVars><variable name="v">'
    "<type><INT/></type></variable></inputVars></interface><body><ST><xhtml:p>"
    "CHECKED := v; ENO := v &lt; 100;</xhtml:p></ST></body></pou>"
)


def test_the_eno_of_a_block_whose_code_may_set_it_is_an_output() -> None:
    """In the other dialects no code can set it, so it is the value of EN."""
    drawn = fbd(
        source("1", "x"),
        source("2", "a"),
        block("3", "CHECKED", {"EN": "1", "v": "2"}, "ENO OUT"),
        sink("4", "c", "3.OUT"),
        sink("5", "y", "3.ENO"),
    ).replace("<pous>", f"<pous>{CHECKED}")
    before = "Net1_Enable1 := x; IF Net1_Enable1 THEN c := CHECKED(a"
    for dialect, expected in (
        (EDITION_3, f"{before}, ENO => Net1_Ok2); ELSE Net1_Ok2 := FALSE; END_IF y := Net1_Ok2;"),
        (CODESYS, f"{before}); END_IF y := Net1_Enable1;"),
    ):
        unit, mistakes = read_source("test.xml", drawn, dialect)
        assert mistakes == []
        body = unit.declarations[-1]
        assert isinstance(body, tree.Pou)
        assert body.body == tree.StBody(st(expected))


def test_a_block_of_the_file_may_have_an_output_eno_of_its_own() -> None:
    own = (
        '<pou name="GATE" pouType="functionBlock"><interface><outputVars><variable name="ENO"><type><BOOL/></type>'
        "</variable></outputVars></interface><body><ST><xhtml:p>;</xhtml:p></ST></body></pou>"
    )
    gate = block("2", "GATE", {}, "ENO", 'instanceName="g1"')
    drawn = fbd(gate, sink("3", "y", "2.ENO"), g1='<derived name="GATE"/>').replace("<pous>", f"<pous>{own}")
    for dialect, expected in ((CODESYS, "g1(); y := g1.ENO;"), (EDITION_3, "g1(ENO => Net1_Ok1); y := Net1_Ok1;")):
        unit, mistakes = read_source("test.xml", drawn, dialect)
        assert mistakes == []
        body = unit.declarations[-1]
        assert isinstance(body, tree.Pou)
        assert body.body == tree.StBody(st(expected))


def test_a_division_whose_eno_is_used_is_a_function_with_eno() -> None:
    drawn = fbd(
        source("1", "a"),
        source("2", "b"),
        block("3", "DIV", {"IN1": "1", "IN2": "2"}, "ENO OUT"),
        sink("4", "c", "3.OUT"),
        sink("5", "y", "3.ENO"),
    )
    assert statements(drawn) == st("Net1_Result2 := DIV(a, b, ENO => Net1_Ok1); c := Net1_Result2; y := Net1_Ok1;")
    assert statements(drawn.replace('"DIV"', '"MUL"')) == st("c := a * b; y := TRUE;")


def test_a_variable_at_eno_itself_is_written() -> None:
    """Part 10 draws no element for it."""
    pin = (
        '<variable formalParameter="ENO"><connectionPointOut><expression>y</expression></connectionPointOut></variable>'
    )
    drawn = fbd(source("1", "x"), source("2", "y"), block("3", "TON", {"EN": "1", "IN": "2"}, "Q", 'instanceName="t1"'))
    text = drawn.replace("</outputVariables>", f"{pin}</outputVariables>")
    assert statements(text) == st("Net1_Enable1 := x; IF Net1_Enable1 THEN t1(IN := y); END_IF y := Net1_Enable1;")


def test_a_comparison_without_power_is_false() -> None:
    drawn = fbd(
        source("1", "x"),
        source("2", "a"),
        source("3", "b"),
        block("4", "GT", {"EN": "1", "In2": "2", "In3": "3"}, "Out1"),
        sink("5", "y", "4.Out1"),
    )
    assert statements(drawn) == st("Net1_Enable1 := x; y := Net1_Enable1 AND a > b;")


def test_a_block_of_the_file_may_have_an_input_en_of_its_own() -> None:
    own = (
        '<pou name="GATE" pouType="functionBlock"><interface><inputVars><variable name="EN"><type><BOOL/></type>'
        "</variable></inputVars></interface><body><ST><xhtml:p>;</xhtml:p></ST></body></pou>"
    )
    drawn = fbd(source("1", "x"), block("2", "GATE", {"EN": "1"}, "", 'instanceName="g1"'))
    text = drawn.replace("<pous>", f"<pous>{own}")
    body = read(text)[0].declarations[-1]
    assert isinstance(body, tree.Pou)
    assert body.body == tree.StBody(st("g1(EN := x);"))


def test_a_function_with_several_outputs_fills_hidden_variables() -> None:
    own = (
        '<pou name="SPLIT" pouType="function"><interface><returnType><INT/></returnType><inputVars><variable name="v">'
        '<type><INT/></type></variable></inputVars><outputVars><variable name="rest"><type><INT/></type></variable>'
        "</outputVars></interface><body><ST><xhtml:p>;</xhtml:p></ST></body></pou>"
    )
    drawn = fbd(
        source("1", "a"),
        block("2", "SPLIT", {"v": "1"}, "SPLIT rest"),
        sink("3", "b", "2.SPLIT"),
        sink("4", "c", "2.rest"),
    )
    unit, mistakes = read(drawn.replace("<pous>", f"<pous>{own}"))
    assert mistakes == []
    body = unit.declarations[-1]
    assert isinstance(body, tree.Pou)
    assert body.body == tree.StBody(
        st("""
            Net1_Result2 := SPLIT(v := a, rest => Net1_Output1);
            b := Net1_Result2;
            c := Net1_Output1;""")
    )


def test_in_out_pins_pass_the_variable() -> None:
    drawn = fbd(
        source("1", "a"),
        '<block localId="2" typeName="SWAP" instanceName="s1"><inputVariables/><inOutVariables>'
        '<variable formalParameter="v"><connectionPointIn><connection refLocalId="1"/></connectionPointIn>'
        "<connectionPointOut/></variable></inOutVariables><outputVariables/></block>",
        sink("3", "b", "2.v"),
        s1='<derived name="SWAP"/>',
    )
    assert statements(drawn) == st("s1(v := a); b := a;")


def test_the_order_of_the_author_makes_a_block_use_old_values() -> None:
    drawn = fbd(
        block("1", "TON", {"IN": "2.Q"}, "Q", 'instanceName="t1" executionOrderId="1"'),
        source("3", "x"),
        block("2", "TON", {"IN": "3"}, "Q", 'instanceName="t2" executionOrderId="2"'),
        t2='<derived name="TON"/>',
    )
    assert statements(drawn) == st("t1(IN := t2.Q); t2(IN := x);")


def test_a_call_without_result_is_a_statement() -> None:
    assert statements(fbd(source("1", "a"), block("2", "LOGTEXT", {"v": "1"}, ""))) == st("LOGTEXT(a);")


@pytest.mark.parametrize(
    "drawn",
    [
        fbd(block("2", "TON", {'IN storage="set"': "1"}, "Q", 'instanceName="t1"')),
        fbd('<inOutVariable localId="3" edgeOut="rising"><expression>x</expression></inOutVariable>'),
        fbd(block("2", "TON", {}, "Q", 'instanceName="t1"').replace('"Q"', '"Q" edge="falling"')),
    ],
)
def test_modifiers_where_they_have_no_meaning_are_refused(drawn: str) -> None:
    assert any("at an output or a pin" in message for message in messages(drawn))


@pytest.mark.long
def test_a_chain_of_thousands_is_a_message_even_deep_inside_of_the_program() -> None:
    """The caller of the import may itself be far from the bottom of Python's stack."""
    through = "".join(
        f'<inOutVariable localId="{n}"><connectionPointIn><connection refLocalId="{n - 1}"/></connectionPointIn>'
        f"<connectionPointOut/><expression>a</expression></inOutVariable>"
        for n in range(2, 2_000)
    )
    drawn = fbd(source("1", "a"), sink("9999", "b", "1999"), through)

    def deep(levels: int) -> list[str]:
        return deep(levels - 1) if levels else messages(drawn)

    assert any("elements in a row" in message for message in deep(150))
