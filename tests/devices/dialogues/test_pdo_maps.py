"""PDOs that a log or an EDS describes (CiA 301, 7.5.2.35 to 7.5.2.38)."""

import pytest
from canopen_bench import IO32
from hypothesis import given
from hypothesis import strategies as st
from logs import can_log

from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.dialogues import PdoMaps, SdoTransfer, dialogues

MAPPED = (
    "605#2F 00 1A 00 00 00 00 00", "585#60 00 1A 00 00 00 00 00",
    "605#23 00 1A 01 08 02 00 60", "585#60 00 1A 01 00 00 00 00",  # 6000:02, 8 bits
    "605#23 00 1A 02 10 01 01 64", "585#60 00 1A 02 00 00 00 00",  # 6401:01, 16 bits
    "605#2F 00 1A 00 02 00 00 00", "585#60 00 1A 00 00 00 00 00",
)  # fmt: skip
MOVED = ("605#23 00 18 01 81 06 00 00", "585#60 00 18 01 00 00 00 00")  # COB-ID 681h
READ = (
    "605#40 00 1A 00 00 00 00 00", "585#4F 00 1A 00 02 00 00 00",
    "605#40 00 1A 01 00 00 00 00", "585#43 00 1A 01 08 02 00 60",
    "605#40 00 1A 02 00 00 00 00", "585#43 00 1A 02 10 01 01 64",
)  # fmt: skip
IN_SEGMENTS = (
    "605#21 00 1A 01 04 00 00 00", "585#60 00 1A 01 00 00 00 00",
    "605#07 08 02 00 60 00 00 00", "585#20 00 00 00 00 00 00 00",
)  # fmt: skip
LAYOUT = [(5, 0x6000, 2, 8), (5, 0x6401, 1, 16)]


@pytest.fixture
def with_eds() -> PdoMaps:
    return PdoMaps({5: load(IO32, 5)})


def learn(maps: PdoMaps, *frames: str) -> PdoMaps:
    for found in dialogues(can_log(*frames)):
        if isinstance(found, SdoTransfer):
            maps.take(found)
    return maps


def test_a_node_without_eds_has_the_predefined_connection_set() -> None:
    """7.3.5: four PDOs of each direction, whose mapping is not known."""
    maps = PdoMaps()
    kinds = {key: (pdo.node_id, pdo.kind) for key in range(0x800) if (pdo := maps.pdo_of(key)) is not None}
    assert len(kinds) == 8 * 127
    assert (kinds[0x185], kinds[0x205], kinds[0x57F]) == ((5, "TPDO 1"), (5, "RPDO 1"), (127, "RPDO 4"))
    assert maps.layout_of(0x185) is None
    assert maps.layout_of(0x180) is None


def test_an_eds_gives_identifiers_and_mappings(with_eds: PdoMaps) -> None:
    layout = with_eds.layout_of(0x185)
    assert layout is not None
    assert [bits for *_, bits in layout] == [8, 8, 8, 8]


@pytest.mark.parametrize("frames", [MAPPED, READ], ids=["written", "read"])
@pytest.mark.parametrize("has_eds", [True, False])
def test_a_mapping_of_the_log_wins(with_eds: PdoMaps, frames: tuple[str, ...], has_eds: bool) -> None:
    maps = learn(with_eds if has_eds else PdoMaps(), *frames)
    assert maps.layout_of(0x185) == LAYOUT


def test_an_identifier_of_the_log_wins(with_eds: PdoMaps) -> None:
    maps = learn(with_eds, *MAPPED, *MOVED)
    assert maps.layout_of(0x681) == LAYOUT
    assert maps.pdo_of(0x185) is None
    learn(maps, "605#23 00 18 01 81 06 00 80", MOVED[1])  # bit 31: the PDO is not valid
    assert maps.pdo_of(0x681) is None


def test_a_node_without_eds_loses_its_predefined_identifier_when_another_is_seen() -> None:
    maps = learn(PdoMaps(), *MOVED)
    assert maps.pdo_of(0x681) is not None
    assert maps.pdo_of(0x185) is None
    assert maps.pdo_of(0x285) is not None


def test_a_parameter_that_comes_in_segments_counts_too(with_eds: PdoMaps) -> None:
    maps = learn(with_eds, *MAPPED[:2], *IN_SEGMENTS, "605#2F 00 1A 00 01 00 00 00", MAPPED[1])
    assert maps.layout_of(0x185) == LAYOUT[:1]


def test_a_refused_download_changes_nothing(with_eds: PdoMaps) -> None:
    before = with_eds.layout_of(0x185)
    learn(with_eds, MAPPED[0], "585#80 00 1A 00 22 00 00 08")
    assert with_eds.layout_of(0x185) == before


def test_an_identifier_of_29_bits_is_a_key_with_bit_31() -> None:
    maps = learn(PdoMaps(), "605#23 00 18 01 81 06 00 20", MOVED[1])
    assert maps.pdo_of(0x681) is None
    assert maps.pdo_of(0x8000_0681) is not None


def test_a_multiplexed_pdo_has_no_layout() -> None:
    maps = learn(PdoMaps(), "605#2F 00 1A 00 FE 00 00 00", MAPPED[1])
    assert maps.layout_of(0x185) is None


def test_a_log_that_shows_only_a_part_of_a_mapping_shows_no_layout() -> None:
    assert learn(PdoMaps(), *READ[:4]).layout_of(0x185) is None


@given(
    st.lists(
        st.tuples(st.integers(0, 127), st.integers(0x1400, 0x1BFF), st.integers(0, 255), st.integers(0, 2**32 - 1))
    )
)
def test_any_numbers_are_taken(numbers: list[tuple[int, int, int, int]]) -> None:
    maps = PdoMaps()
    for node_id, index, subindex, number in numbers:
        maps.put(node_id, index, subindex, number)
    for key in (0x185, 0x205, 0x8000_0681):
        maps.layout_of(key)


numbers_of_few = st.tuples(
    st.integers(1, 3),
    st.sampled_from([0x1400, 0x1401, 0x1800, 0x1A00]),
    st.sampled_from([0, 1]),
    st.sampled_from([0, 0x181, 0x201, 0x681, 0x8000_0681, 0x2000_0681]),
)


@given(st.lists(numbers_of_few, max_size=20))
def test_a_pdo_is_one_whose_last_identifier_it_is(numbers: list[tuple[int, int, int, int]]) -> None:
    maps, last = PdoMaps(), dict[tuple[int, int], int]()
    for node_id, index, subindex, number in numbers:
        maps.put(node_id, index, subindex, number)
        if subindex == 1 and index != 0x1A00:
            last[node_id, index] = number
    for cob_id, key in ((0x681, 0x681), (0x2000_0681, 0x8000_0681)):
        users = {(node_id, index + 0x200) for (node_id, index), number in last.items() if number == cob_id}
        pdo = maps.pdo_of(key)
        assert (pdo is None) == (not users)
        if pdo is not None:
            assert (pdo.node_id, pdo.mapping) in users
            assert pdo.kind.startswith("TPDO") == any(mapping == 0x1A00 for _, mapping in users)
