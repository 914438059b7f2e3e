"""Exchange of variables and flag words between cards (manual line 91; digest I-38)."""

from pathlib import Path
from typing import Any

import pytest
from arp_face import FaceBench
from pydantic import ValidationError

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.virtual.rig import Rig
from fieldrig_devices.arp.can.exchange import ExchangeSettings

FRAME_NS = 111 * 2_000
"""Time of the longest frame with 4 bytes, at 500 kbit/s."""
PASS_NS = 20 * MS


def two_cards(*, second: dict[str, Any], **first: Any) -> Rig:
    """Card a with node-ID 5, card b with 6."""
    devices = {
        name: {
            "kind": "arp",
            "parameters": {"general": {5: node_id}},
            "exchange": exchange,
            "links": {"can": "can0"},
        }
        for name, node_id, exchange in (("a", 5, first), ("b", 6, second))
    }
    config = {"time": "virtual", "buses": {"can0": {"kind": "can.virtual"}}, "devices": devices}
    return Rig(from_dict(config, Path()))


@pytest.mark.long
@pytest.mark.manual("ARP-003")
def test_a_variable_of_one_card_is_in_the_other_within_a_pass_and_a_frame() -> None:
    with two_cards(
        send=[{"channel": 1, "words": ["V10"]}], second={"receive": [{"node": 5, "channel": 1, "words": ["V110"]}]}
    ) as rig:
        rig.run_until(50 * MS)
        rig.set("a", "V10", 12.345)
        rig.run_until(50 * MS + PASS_NS + FRAME_NS)
        assert rig.get("b", "V110") == 12.345
        assert rig.get("b", "V10") == 0


@pytest.mark.manual("ARP-003")
def test_both_ways_with_flag_words() -> None:
    with two_cards(
        send=[{"channel": 1, "words": ["V1", "FLAG2"]}],
        receive=[{"node": 6, "channel": 4, "words": ["V2"]}],
        second={
            "send": [{"channel": 4, "words": ["V1"]}],
            "receive": [{"node": 5, "channel": 1, "words": ["V2", "FLAG1"]}],
        },
    ) as rig:
        rig.set("a", "V1", 1)
        rig.set("a", "F34", True)
        rig.set("a", "F64", True)
        rig.set("b", "V1", -2)
        rig.run_until(100 * MS)
        assert (rig.get("a", "V2"), rig.get("b", "V2")) == (-2, 1)
        assert [number for number in range(1, 65) if rig.get("b", f"F{number}")] == [2, 32]


@pytest.mark.manual("ARP-003")
def test_each_channel_has_words_of_its_own() -> None:
    with two_cards(
        send=[{"channel": channel, "words": [f"V{channel}"]} for channel in (1, 2, 3)],
        second={"receive": [{"node": 5, "channel": channel, "words": [f"V{10 * channel}"]} for channel in (1, 2, 3)]},
    ) as rig:
        for channel in (1, 2, 3):
            rig.set("a", f"V{channel}", 7 + channel)
        rig.run_until(100 * MS)
        assert [rig.get("b", f"V{10 * channel}") for channel in (1, 2, 3)] == [8, 9, 10]


@pytest.mark.long
def test_cards_without_exchange_say_nothing_to_each_other() -> None:
    with two_cards(second={}) as rig:
        rig.set("a", "V10", 1)
        rig.run_until(100 * MS)
        assert [rig.get("b", f"V{number}") for number in range(1, 13)] == [0] * 12


@pytest.fixture
def sender() -> FaceBench:
    """Node 10, which starts itself; its first frames are already taken."""
    bench = FaceBench(send=[{"channel": 2, "words": ["V10", "flag2"], "every_ms": 500, "inhibit_ms": 30}])
    assert "34A#00 00 00 00 00 00 00 00" in bench.start()
    bench.after(30)
    return bench


@pytest.mark.long
def test_a_channel_has_a_can_id_by_its_card(sender: FaceBench) -> None:
    sender.card.V[10], sender.card.F[33] = 1500, 1
    assert sender.refresh() == ["34A#dc 05 00 00 01 00 00 00"]


def test_a_channel_waits_between_two(sender: FaceBench) -> None:
    sender.card.V[10] = 1
    assert sender.refresh() == ["34A#01 00 00 00 00 00 00 00"]
    sender.card.V[10] = 2
    assert sender.refresh() == []
    assert sender.after(29) == []
    assert sender.after(1) == ["34A#02 00 00 00 00 00 00 00"]


def test_a_channel_repeats_itself(sender: FaceBench) -> None:
    assert sender.after(469) == []
    assert sender.after(1) == ["34A#00 00 00 00 00 00 00 00"]


def test_a_channel_at_sync() -> None:
    bench = FaceBench(send=[{"channel": 1, "words": ["POS2", "VEL2"], "at": "sync"}])
    bench.start()
    bench.card.positions[2] = 1500
    assert "24A" not in str(bench.refresh())
    assert bench.send("080#") == ["24A#dc 05 00 00 00 00 00 00"]


def test_a_card_may_make_the_sync() -> None:
    bench = FaceBench(sync_ms=10, send=[{"channel": 1, "words": ["V1"], "at": "sync"}])
    bench.start()
    assert bench.after(10) == ["080#", "24A#00 00 00 00"]
    assert bench.after(10) == ["080#", "24A#00 00 00 00"]


@pytest.mark.long
@pytest.mark.manual("ARP-003")
def test_receptions_leave_the_card_s_own_pdos_to_the_master() -> None:
    bench = FaceBench(
        receive=[{"node": 5, "channel": channel, "words": [f"V{100 + channel}"]} for channel in (1, 2, 3, 4)]
    )
    bench.start()
    for channel, can_id in enumerate(("245", "345", "445", "545"), start=1):
        bench.send(f"{can_id}#{channel:02x} 00 00 00")
    assert bench.card.V[101:105] == [1, 2, 3, 4]
    for can_id in ("30A", "40A", "50A"):
        bench.send(f"{can_id}#0{can_id[0]} 00 00 00 01 00 00 00")
    assert bench.card.V[1:7] == [3, 1, 4, 1, 5, 1]


def test_reception_is_reported_as_failed_after_its_time() -> None:
    bench = FaceBench(receive=[{"node": 5, "channel": 1, "words": ["V7"], "timeout_ms": 100}])
    bench.start()
    bench.send("245#01 00 00 00")
    assert bench.card.V[7] == 1
    assert bench.after(99) == []
    assert bench.after(1) == ["08A#50 82 11 00 00 00 00 00"]
    assert bench.send("245#02 00 00 00") == ["08A#00 00 00 00 00 00 00 00"]


def test_a_reception_that_is_too_short_is_reported() -> None:
    bench = FaceBench(receive=[{"node": 5, "channel": 1, "words": ["V7", "V8"]}])
    bench.start()
    assert bench.send("245#01 00 00 00") == ["08A#10 82 11 04 08 00 00 00"]
    assert bench.card.V[7:9] == [0, 0]


@pytest.mark.long
@pytest.mark.parametrize(
    ("word", "entry"),
    [
        ("V1", 0x2000_0120),
        ("V250", 0x2000_FA20),
        ("V251", 0x2001_0120),
        ("V1000", 0x2003_FA20),
        ("FLAG10", 0x2010_0A20),
        ("OUT1", 0x2011_0120),
        ("INP3", 0x2012_0320),
        ("POS2", 0x2200_0220),
        ("VEL1", 0x2201_0120),
    ],
)
def test_a_foreign_tool_sees_the_exchange_as_pdo_mapping(word: str, entry: int) -> None:
    """TPDO 5 is the first channel."""
    bench = FaceBench(send=[{"channel": 1, "words": [word]}])
    bench.start()
    assert bench.sdo("40 04 1A 00 00 00 00 00") == "4f 04 1a 00 01 00 00 00"
    assert bench.sdo("40 04 1A 01 00 00 00 00") == f"43 04 1a 01 {entry.to_bytes(4, 'little').hex(' ')}"
    assert bench.sdo("40 04 18 01 00 00 00 00") == "43 04 18 01 4a 02 00 00"


def test_a_card_that_waits_for_a_master() -> None:
    bench = FaceBench(send=[{"channel": 1, "words": ["V1"]}], starts_itself=False)
    assert bench.start() == ["70A#00"]


@pytest.mark.long
def test_no_card_beyond_node_63_can_send(caplog: pytest.LogCaptureFixture) -> None:
    bench = FaceBench(send=[{"channel": 1, "words": ["V1"]}])
    bench.card.parameters.ram[0][5] = 64_000
    assert not [frame for frame in bench.start() if frame.startswith("280#")]
    assert "up to 63" in caplog.text


@pytest.mark.parametrize(
    ("wrong", "remedy"),
    [
        ({"send": [{"channel": 1, "words": ["V1001"]}]}, "V1 to V1000"),
        ({"send": [{"channel": 1, "words": ["V0"]}]}, "V1 to V1000"),
        ({"send": [{"channel": 1, "words": ["X"]}]}, "V1 to V1000"),
        ({"send": [{"channel": 1, "words": ["V1", "V2", "V3"]}]}, "at most 2"),
        ({"send": [{"channel": 5, "words": ["V1"]}]}, "less than or equal to 4"),
        ({"send": [{"channel": 1, "words": ["V1"]}, {"channel": 1, "words": ["V2"]}]}, "each channel at most once"),
        ({"receive": [{"node": 64, "channel": 1, "words": ["V1"]}]}, "less than or equal to 63"),
        ({"receive": [{"node": 5, "channel": 1, "words": ["POS1"]}]}, "cannot be written"),
        ({"receive": [{"node": 5, "channel": 1, "words": ["INP1"]}]}, "V1 to V1000, FLAG1 to 10 or OUT1 to 3"),
    ],
)
def test_wrong_settings_are_refused_with_a_remedy(wrong: dict[str, Any], remedy: str) -> None:
    with pytest.raises(ValidationError, match=remedy):
        ExchangeSettings.model_validate(wrong)


def test_a_rig_names_the_key() -> None:
    with pytest.raises(RigError, match="exchange"):
        two_cards(send=[{"channel": 9, "words": ["V1"]}], second={})
