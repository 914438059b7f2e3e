"""Names of CANopen messages: the bytes are those of CiA 301's own pictures of the protocols (7.2.2 to 7.2.8)."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import from_dict
from fieldrig.traces.names import Named, Namer, namer_of
from fieldrig_bus.can.frame import CanFrame

CONFIGS = Path(__file__).parents[3] / "configs"
RIG = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual"}},
    "devices": {
        "io": {"kind": "canopen.node", "node_id": 5, "eds": "eds/io32.eds", "links": {"can": "can0"}},
        "belt": {"kind": "cia402.drive", "node_id": 8, "links": {"can": "can0"}},
    },
}


@pytest.fixture(scope="module")
def config() -> object:
    return from_dict(RIG, CONFIGS)


@pytest.fixture
def name(config: object) -> Namer:
    return namer_of(config, "can0")  # type: ignore[arg-type]


def frame(text: str) -> CanFrame:
    identifier, _, data = text.partition("#")
    return CanFrame(int(identifier, 16), bytes.fromhex(data))


@pytest.mark.parametrize(
    ("sent", "kind", "node", "text"),
    [
        ("000#01 05", "NMT", "io", "start"),
        ("000#80 00", "NMT", "", "enter pre-operational all nodes"),
        ("080#", "SYNC", "", ""),
        ("080#07", "SYNC", "", "counter 7"),
        ("705#00", "boot-up", "io", ""),
        ("705#05", "heartbeat", "io", "operational"),
        ("705#FF", "heartbeat", "io", "pre-operational"),  # answer to guarding, toggle bit set
        ("085#00 10 01 00 00 00 00 00", "EMCY", "io", "1000h generic error, register 01h (generic)"),
        ("085#30 81 11 00 00 00 00 00", "EMCY", "io",
         "8130h life guard or heartbeat error, register 11h (generic communication)"),
        ("085#00 00 00 00 00 00 00 00", "EMCY", "io", "0000h error reset or no error, register 00h"),
        ("605#40 00 10 00 00 00 00 00", "SDO read", "io", "1000:00 Device type"),
        ("585#43 00 10 00 91 01 0F 00", "SDO value", "io", "1000:00 Device type = 983441 (F0191h)"),
        ("605#2F 00 62 01 0F 00 00 00", "SDO write", "io", "6200:01 Write outputs byte 1 = 15 (Fh)"),
        ("585#60 00 62 01 00 00 00 00", "SDO written", "io", "6200:01 Write outputs byte 1"),
        ("585#80 00 62 09 11 00 09 06", "SDO abort", "io", "6200:09: 0609 0011h no sub index"),
        ("605#21 08 10 00 14 00 00 00", "SDO write", "io", "1008:00 Manufacturer device name = 20 bytes in segments"),
        ("608#40 41 60 00 00 00 00 00", "SDO read", "belt", "6041:00 Statusword"),
        ("70A#05", "heartbeat", "node 10", "operational"),
        ("100#40 77 1B 00 52 36", "TIME", "", "2022-01-27 00:30:00.000"),
        ("7E5#04 01 00 00 00 00 00 00", "LSS request", "", "switch state global configuration"),
    ],
)  # fmt: skip
def test_frame_has_the_name_of_its_service(name: Namer, sent: str, kind: str, node: str, text: str) -> None:
    named = name(frame(sent))
    assert (named.kind, named.node) == (kind, node)
    assert named.text.lower() == text.lower()


def test_pdo_has_the_names_and_values_of_its_objects(name: Namer) -> None:
    named = name(frame("205#0F 00 80 01"))
    assert (named.kind, named.node) == ("RPDO 1", "io")
    assert named.text.count("15 (Fh)") == 1
    assert named.text.count("128 (80h)") == 1


def test_pdo_follows_a_mapping_that_a_master_changes_by_sdo(name: Namer) -> None:
    """The procedure of CiA 301 7.5.2.36, as a master sends it, with the answers of the node."""
    before = name(frame("185#01 02 03 04"))
    exchange = (
        "605#23 00 18 01 85 01 00 80", "585#60 00 18 01 00 00 00 00",  # the PDO is not valid
        "605#2F 00 1A 00 00 00 00 00", "585#60 00 1A 00 00 00 00 00",
        "605#23 00 1A 01 08 02 00 60", "585#60 00 1A 01 00 00 00 00",  # 6000:02, 8 bits
        "605#2F 00 1A 00 01 00 00 00", "585#60 00 1A 00 00 00 00 00",
        "605#23 00 18 01 95 01 00 00", "585#60 00 18 01 00 00 00 00",  # COB-ID 195h
    )  # fmt: skip
    for sent in exchange:
        name(frame(sent))
    after = name(frame("195#2A"))
    assert (after.kind, after.node) == ("TPDO 1", "io")
    assert after.text.endswith(" 42 (2Ah)")
    assert after.text.count(",") == 0 < before.text.count(",")
    assert name(frame("185#01 02 03 04")).kind == ""


def test_a_refused_download_changes_no_name(name: Namer) -> None:
    name(frame("605#23 00 18 01 95 01 00 00"))
    name(frame("585#80 00 18 01 22 00 00 08"))
    assert name(frame("185#00 00 00 00")).kind == "TPDO 1"


def test_a_pdo_that_is_too_short_says_so(name: Namer) -> None:
    assert name(frame("205#0F")).text.endswith("too short for its mapping")


@given(
    identifier=st.integers(0, 0x7FF),
    data=st.binary(max_size=8),
)
def test_any_frame_has_some_name(config: object, identifier: int, data: bytes) -> None:
    named = namer_of(config, "can0")(CanFrame(identifier, data))  # type: ignore[arg-type]
    assert isinstance(named, Named)
