"""PDOs of the card: their default content, and what a PLC may map."""

import pytest
from arp_face import FaceBench
from hypothesis import given, settings
from hypothesis import strategies as st

STATE_AT_START = "18A#03 00 00 00 00 00 00 00"
ALL_AT_START = [STATE_AT_START, *(f"{identifier}#00 00 00 00 00 00 00 00" for identifier in ("28A", "38A", "48A"))]


@pytest.fixture
def bench() -> FaceBench:
    bench = FaceBench()
    bench.start()
    assert bench.send("000#01 0A") == ALL_AT_START
    return bench


def test_state_error_and_flags_go_out_in_the_first(bench: FaceBench) -> None:
    bench.card.F[1] = bench.card.F[32] = 1
    assert bench.refresh() == ["18A#03 00 00 00 01 00 00 80"]


def test_positions_speeds_and_axis_flags_in_the_others(bench: FaceBench) -> None:
    card = bench.card
    card.positions.update({1: 1500, 2: -1500})
    card.speeds[2], card.F[260], card.F[300] = 1000, 1, 1
    assert bench.refresh() == [
        "28A#dc 05 00 00 24 fa ff ff",
        "38A#00 00 00 00 e8 03 00 00",
        "48A#08 00 00 00 00 08 00 00",
    ]


def test_nothing_goes_out_between_passes_or_without_a_change(bench: FaceBench) -> None:
    bench.card.positions[1] = 1
    assert bench.after(1000) == []
    assert len(bench.refresh()) == 1
    assert bench.refresh() == []


def test_first_pdo_carries_what_is_true_when_the_node_starts(bench: FaceBench) -> None:
    bench.send("000#80 0A")
    bench.card.positions[1] = 1500
    assert bench.send("000#01 0A")[1] == "28A#dc 05 00 00 00 00 00 00"


def test_what_a_master_maps_is_up_to_date_from_its_first_pdo_on(bench: FaceBench) -> None:
    """TPDO 8, off by default: V1000 and the first word of inputs."""
    bench.card.V[1000], bench.card.I[101] = 1500, 1
    for request in (
        "23 07 1A 01 20 FA 03 20",
        "23 07 1A 02 20 01 12 20",
        "2F 07 1A 00 02 00 00 00",
    ):
        assert bench.sdo(request)[:2] == "60"
    assert bench.send("60A#23 07 18 01 CA 04 00 00")[0] == "58A#60 07 18 01 00 00 00 00"
    bench.card.V[1000] = 1501
    assert bench.refresh() == ["4CA#dd 05 00 00 01 00 00 00"]


@pytest.mark.long
def test_with_sync_the_card_tells_what_the_last_pass_saw(bench: FaceBench) -> None:
    bench.sdo("2F 01 18 02 01 00 00 00")
    bench.card.positions[1] = 1500
    assert bench.send("080#") == ["28A#00 00 00 00 00 00 00 00"]
    bench.refresh()
    bench.card.positions[1] = 1600
    assert bench.send("080#") == ["28A#dc 05 00 00 00 00 00 00"]


@pytest.mark.long
def test_variables_and_flags_arrive_at_once(bench: FaceBench) -> None:
    bench.send("20A#00 00 00 00 01 00 00 80", "30A#E8 03 00 00 18 FC FF FF")
    assert (bench.card.F[33], bench.card.F[64]) == (1, 1)
    assert bench.card.V[1:3] == [1000, -1000]


def test_variables_of_rpdo_3_and_4(bench: FaceBench) -> None:
    bench.send("40A#03 00 00 00 04 00 00 00", "50A#05 00 00 00 06 00 00 00")
    assert bench.card.V[3:7] == [3, 4, 5, 6]


def test_pdos_are_not_taken_before_operational() -> None:
    bench = FaceBench()
    bench.start()
    bench.send("30A#E8 03 00 00 18 FC FF FF")
    assert bench.card.V[1:3] == [0, 0]


def test_a_pdo_that_is_refused_changes_nothing_and_the_rest_arrives(bench: FaceBench) -> None:
    """RPDO 8: the word of local outputs, which the card holds at 0, and V7."""
    for request in (
        "23 07 16 01 20 01 11 20",
        "23 07 16 02 20 07 00 20",
        "2F 07 16 00 02 00 00 00",
        "23 07 14 01 80 03 00 00",
    ):
        assert bench.sdo(request)[:2] == "60"
    bench.card.is_willing = False
    bench.send("380#01 00 00 00 02 00 00 00")
    assert (bench.card.O[101], bench.card.V[7]) == (0, 2)


def test_inputs_and_positions_can_not_be_mapped_to_be_received(bench: FaceBench) -> None:
    assert bench.sdo("23 07 16 01 20 01 12 20") == "80 07 16 01 41 00 04 06"
    assert bench.sdo("23 07 16 01 20 01 00 22") == "80 07 16 01 41 00 04 06"


def test_reset_of_the_node_does_not_reset_the_card(bench: FaceBench) -> None:
    bench.card.V[1], bench.card.F[1] = 5, 1
    assert bench.send("000#81 0A") == ["70A#00"]
    assert (bench.card.V[1], bench.card.F[1], bench.card.asked) == (5, 1, [])
    assert bench.sdo("40 00 20 01 00 00 00 00") == "43 00 20 01 05 00 00 00"


@settings(max_examples=30, deadline=None)
@given(
    identifier=st.sampled_from(["000", "080", "20A", "30A", "40A", "50A", "60A", "70A"]),
    data=st.binary(max_size=8),
)
@pytest.mark.long
def test_whatever_comes_in_the_card_goes_on(identifier: str, data: bytes) -> None:
    bench = FaceBench()
    bench.start()
    bench.send("000#01 0A", f"{identifier}#{data.hex()}")
    bench.refresh()
    bench.send("000#01 0A")
    assert bench.sdo("40 07 21 00 00 00 00 00") == "4f 07 21 00 07 00 00 00"
