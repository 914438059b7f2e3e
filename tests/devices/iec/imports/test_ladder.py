"""Ladder diagram of PLCopen XML: contacts, coils, branches, labels, jumps (manual 1856 to 1913)."""

import pytest
from exchange_documents import coil, contact, messages, only_pou, pou, rail, st, statements, tc6

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.imports.networks.flow import HIGHEST
from fieldrig_devices.iec.imports.networks.functions import height

BOOLS = dict.fromkeys(("a", "b", "c", "m", "n"), "BOOL")


def ladder(*elements: str, **variables: str) -> str:
    return tc6(pou(f"<LD>{rail()}{''.join(elements)}</LD>", variables={**BOOLS, **variables}))


def test_contacts_in_a_row_are_connected_by_and() -> None:
    drawn = ladder(contact("1", "a", "0"), contact("2", "b", "1", attributes='negated="true"'), coil("3", "m", "2"))
    assert statements(drawn) == st("m := a AND NOT b;")


def test_parallel_branches_are_connected_by_or() -> None:
    drawn = ladder(contact("1", "a", "0"), contact("2", "m", "0"), contact("3", "b", "1", "2"), coil("4", "m", "3"))
    assert statements(drawn) == st("m := (a OR m) AND b;")


def test_a_coil_at_the_rail_is_always_on() -> None:
    assert statements(ladder(coil("1", "m", "0"))) == st("m := TRUE;")


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('negated="true"', "m := NOT a;"),
        ('storage="set"', "IF a THEN m := TRUE; END_IF"),
        ('storage="reset"', "IF a THEN m := FALSE; END_IF"),
        ('storage="set" negated="true"', "IF NOT a THEN m := TRUE; END_IF"),
        ('edge="none" storage="none" negated="false"', "m := a;"),
    ],
)
def test_coils_are_negated_set_and_reset(attributes: str, expected: str) -> None:
    drawn = ladder(contact("1", "a", "0"), coil("2", "m", "1", attributes=attributes))
    assert statements(drawn) == st(expected)


def test_a_rising_edge_of_a_contact_compares_with_the_cycle_before() -> None:
    pou = only_pou(ladder(contact("1", "a", "0", attributes='edge="rising"'), coil("2", "m", "1")))
    assert isinstance(pou.body, tree.StBody)
    assert pou.body.statements == st("""
        Net1_Edge2 := a AND NOT Net1_Before1;
        Net1_Before1 := a;
        m := Net1_Edge2;""")
    assert [v.name for v in pou.blocks[-1].variables] == ["Net1_Before1", "Net1_Edge2"]


def test_a_falling_edge_of_a_coil_uses_the_power_in_front_of_it() -> None:
    drawn = ladder(contact("1", "a", "0"), contact("2", "b", "1"), coil("3", "m", "2", attributes='edge="falling"'))
    assert statements(drawn) == st("""
        Net1_Now1 := a AND b;
        Net1_Edge3 := Net1_Before2 AND NOT Net1_Now1;
        Net1_Before2 := Net1_Now1;
        m := Net1_Edge3;""")


def test_power_that_two_coils_take_is_calculated_once() -> None:
    """Otherwise the second coil would see what the first one has changed."""
    drawn = ladder(contact("1", "m", "0", attributes='negated="true"'), coil("2", "m", "1"), coil("3", "n", "1"))
    assert statements(drawn) == st("Net1_Power1 := NOT m; m := Net1_Power1; n := Net1_Power1;")


def test_coils_in_a_row_take_the_same_power() -> None:
    drawn = ladder(contact("1", "a", "0"), coil("2", "m", "1", attributes='negated="true"'), coil("3", "n", "2"))
    assert statements(drawn) == st("m := NOT a; n := a;")


@pytest.mark.manual("PD-380")
def test_nothing_is_carried_from_one_network_to_the_next() -> None:
    drawn = ladder(contact("1", "a", "0"), coil("2", "m", "1"), contact("3", "b", "0"), coil("4", "n", "3"))
    assert statements(drawn) == st("m := a; n := b;")
    (message,) = messages(ladder(contact("1", "a", "0"), coil("2", "m", "1"), coil("3", "n")))
    assert "network 2: The input of the coil n (element 3) is not connected" in message


def test_networks_follow_one_another_from_top_to_bottom() -> None:
    low = '<coil localId="1"><position x="9" y="80"/>{}<variable>m</variable></coil>'
    high = '<coil localId="2"><position x="9" y="20"/>{}<variable>n</variable></coil>'
    wire = '<connectionPointIn><connection refLocalId="0"/></connectionPointIn>'
    assert statements(ladder(low.format(wire), high.format(wire))) == st("n := TRUE; m := TRUE;")


def test_the_order_of_the_author_comes_before_the_position() -> None:
    first = coil("1", "m", "0", attributes='executionOrderId="2"')
    second = coil("2", "n", "0", attributes='executionOrderId="1"')
    assert statements(ladder(first, second)) == st("n := TRUE; m := TRUE;")


def test_labels_jumps_and_returns() -> None:
    jump = '<jump localId="2" label="quick"><connectionPointIn><connection refLocalId="1"/></connectionPointIn></jump>'
    back = '<return localId="4"><connectionPointIn><connection refLocalId="3"/></connectionPointIn></return>'
    drawn = ladder(
        contact("1", "a", "0"),
        jump,
        contact("3", "b", "0"),
        back,
        '<label localId="5" label="quick"/>',
        coil("6", "m", "0"),
    )
    assert statements(drawn) == st("""
        IF a THEN JMP quick; END_IF
        IF b THEN RETURN; END_IF
        quick:
        m := TRUE;""")


def test_a_jump_without_a_wire_is_always_taken() -> None:
    drawn = ladder('<jump localId="1" label="there"/>', '<label localId="2" label="there"/>', coil("3", "m", "0"))
    assert statements(drawn) == st("JMP there; there: m := TRUE;")


def test_connectors_carry_power_to_another_place() -> None:
    wire = '<connectionPointIn><connection refLocalId="1"/></connectionPointIn>'
    away = f'<connector localId="2" name="K1">{wire}</connector>'
    here = '<continuation localId="3" name="K1"><connectionPointOut/></continuation>'
    assert statements(ladder(contact("1", "a", "0"), away, here, coil("4", "m", "3"))) == st("m := a;")


def test_connectors_in_a_circle_are_refused() -> None:
    ring = "".join(
        f'<connector localId="{n}" name="K{n}"><connectionPointIn><connection refLocalId="{n}9"/></connectionPointIn>'
        f'</connector><continuation localId="{n}9" name="K{n}"><connectionPointOut/></continuation>'
        for n in range(1, 4)
    )
    assert any("not connected" in message for message in messages(ladder(ring, coil("8", "m", "19"))))


def test_comments_stay_in_front_of_their_network() -> None:
    comment = '<comment localId="9" height="1" width="1"><content><xhtml:p>Lamp (*top*)</xhtml:p></content></comment>'
    (lamp,) = statements(ladder(comment, coil("1", "m", "0")))
    assert lamp.comments == ("(* Lamp ( *top* ) *)",)


def test_a_hidden_variable_avoids_the_names_of_the_program() -> None:
    drawn = ladder(contact("1", "a", "0"), coil("2", "m", "1"), coil("3", "n", "1"), net1_power1="BOOL")
    assert statements(drawn) == st("Net1_Power1x := a; m := Net1_Power1x; n := Net1_Power1x;")


def test_a_function_has_no_memory_for_an_edge() -> None:
    edge = contact("1", "a", "0", attributes='edge="rising"')
    body = f"<LD>{rail()}{edge}{coil('2', 'm', '1')}</LD>"
    (message,) = messages(tc6(pou(body, variables=BOOLS, kind="function")))
    assert "a function has no memory for it" in message


def test_a_wire_from_nowhere_names_both_ends_and_the_line() -> None:
    (message, *_) = messages(ladder("\n\n", coil("1", "m", "77")))
    assert message.startswith("test.xml:3:1: PROGRAM P, network 1: The coil m (element 1) is connected to element 77")


def test_contacts_in_a_circle_are_refused() -> None:
    (message, *_) = messages(ladder(contact("1", "a", "2"), contact("2", "b", "1"), coil("3", "m", "2")))
    assert "loop of contacts" in message


@pytest.mark.long
def test_a_row_of_thousands_of_contacts_is_a_message() -> None:
    row = "".join(contact(str(n), "a", str(n - 1)) for n in range(1, 3_000))
    assert any("elements in a row" in message for message in messages(ladder(row, coil("9999", "m", "2999"))))


def rungs_of_two(count: int, *first: str) -> str:
    """Two contacts, each fed by both contacts in front of it: the number of paths doubles with each pair."""
    drawn = ""
    wires = first
    for n in range(count):
        drawn += contact(f"{n}a", "a", *wires) + contact(f"{n}b", "b", *wires)
        wires = (f"{n}a", f"{n}b")
    return drawn + coil("end", "m", *wires)


@pytest.mark.parametrize(("first", "expected"), [(("0",), []), (("gone",), ["gone"]), ((), ["not connected"])])
def test_the_number_of_paths_does_not_matter(first: tuple[str, ...], expected: list[str]) -> None:
    found = messages(ladder(rungs_of_two(80, *first)))
    assert len(found) <= 4
    assert all(any(part in message for message in found) for part in expected)


def test_a_long_row_is_divided_by_hidden_variables() -> None:
    row = "".join(contact(str(n), "a", str(n - 1)) for n in range(1, 85))
    found = statements(ladder(row, coil("999", "m", "84")))
    assert len(found) == 3
    assert all(height(found_.value) <= HIGHEST + 1 for found_ in found if isinstance(found_, tree.Assign))


def test_a_thousand_parallel_branches_are_a_low_tree() -> None:
    branches = "".join(contact(str(n), "a", "0") for n in range(1, 1_001))
    (assignment,) = statements(ladder(branches, coil("9999", "m", *map(str, range(1, 1_001)))))
    assert isinstance(assignment, tree.Assign)
    assert height(assignment.value) < 20


@pytest.mark.parametrize(
    ("attributes", "expected"),
    [
        ('edge="upwards"', "The coil m (element 2) has edge='upwards'; expected none, rising, falling"),
        ('storage="latch"', "The coil m (element 2) has storage='latch'; expected none, set, reset"),
        ('negated="yes"', "The coil m (element 2) has negated='yes'; expected true, false, 1, 0"),
    ],
)
def test_a_modifier_that_the_schema_does_not_know_is_refused(attributes: str, expected: str) -> None:
    (message,) = messages(ladder(contact("1", "a", "0"), coil("2", "m", "1", attributes=attributes)))
    assert message.endswith(expected)


def test_a_modifier_is_known_in_any_case_and_with_blanks() -> None:
    drawn = ladder(contact("1", "a", "0", attributes='negated="1"'), coil("2", "m", "1", attributes='storage=" Set "'))
    assert statements(drawn) == st("IF NOT a THEN m := TRUE; END_IF")
