"""A card with other devices in a rig: motor, I/O modules, terminal, and another tool on its CAN."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from arp_bench import CardBench

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.notices import BitRate

ROOT = Path(__file__).parents[4]
PROGRAM = """
BEG MAIN
TERM
MSG 35, "AUTOMATIC CYCLE"
MSG 2, "LENGTH: = #####.#"
V100 == 1234.5
V4 == 35
TERM 4, 1, 1, 35
TERM 5, 2, 1, 2, V100, E
TERM 6, 4, 2, V4
PRINT 35
PAC 1, 500
LOOP:
O201 == I201
O332 == I108
O102 == F245
GOTO LOOP
END
"""
MOTOR = {"rated_torque_nm": 2.0, "motor_inertia_kg_m2": 0.001, "encoder_lines": 10_000}


def cell(folder: Path, **card: Any) -> dict[str, Any]:
    (folder / "cell.I01").write_text(PROGRAM)
    module = {
        "kind": "canopen.node",
        "eds": str(ROOT / "configs/eds/io32.eds"),
        "links": {"can": "can0", "wires": "wires"},
    }
    return {
        "time": "virtual",
        "buses": {"can0": {"kind": "can.virtual", "bitrate": 500_000}, "wires": {"kind": "wires.virtual"}},
        "devices": {
            "motor": {"kind": "plant.servo", "links": {"wires": "wires"}, **MOTOR},
            "io1": {**module, "node_id": 1, "signals": {"6000:01.0": "button", "6200:01.0": "lamp"}},
            "io2": {**module, "node_id": 2, "signals": {"6200:04.7": "ready"}},
            "tr": {"kind": "terminal.tr", "node_id": 20, "links": {"can": "can0"}},
            "card": {
                "kind": "arp",
                "program": "cell.I01",
                "links": {"can": "can0", "wires": "wires"},
                "inputs": {"I108": True},
                "io_nodes": [1, 2],
                "terminal": True,
                "signals": {"dac1": "motor.reference", "encoder1": "motor.encoder"},
                "parameters": {
                    "general": {1: 1, 16: 10},
                    "axis1": {1: 40, 4: 2, 7: 1_000, 8: 10_000, 11: 0.314, 13: 0.006},
                },
                **card,
            },
        },
    }


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    with Rig(from_dict(cell(tmp_path), tmp_path)) as rig:
        rig.run_until(3_000 * MS)
        yield rig


@pytest.mark.long
@pytest.mark.manual("ARP-003")
def test_a18_the_screen_and_the_printer(rig: Rig) -> None:
    texts = ["4 1 1 AUTOMATIC CYCLE", "5 2 1 LENGTH: =  1234.", "6 4 2 AUTOMATIC CYCLE"]
    assert rig.get("tr", "texts") == "\n".join(texts)
    assert rig.get("tr", "printer") == "AUTOMATIC CYCLE"
    assert (rig.get("card", "state"), rig.get("card", "error")) == ("run", 0)


@pytest.mark.long
def test_a_key_of_the_terminal_is_a_flag_of_the_program(rig: Rig) -> None:
    rig.set("tr", "key.F1", True)
    rig.run_until(3_100 * MS)
    assert (rig.get("card", "F245"), rig.get("card", "O102")) == (True, True)


@pytest.mark.long
@pytest.mark.manual("ARP-003", "ARP-040")
def test_remote_inputs_and_outputs_are_the_programs(rig: Rig) -> None:
    outside = rig.attach("person")
    heard: dict[str, object] = {}
    outside.link("wires").on_receive(lambda signal: heard.update({signal.name: signal.value}), ["lamp", "ready"])
    rig.set("io1", "6000:01", 1)
    rig.run_until(3_100 * MS)
    assert heard == {"lamp": True, "ready": True}
    assert rig.get("card", "I201") is True


@pytest.mark.long
@pytest.mark.manual("ARP-046", "ARP-122")
def test_a_card_that_is_reset_has_the_outputs_of_its_modules_at_0(rig: Rig) -> None:
    rig.set("io1", "6000:01", 1)
    rig.run_until(3_100 * MS)
    assert rig.get("io1", "6200:01") == 1
    rig.set("card", "state", "reset")
    rig.run_until(3_200 * MS)
    assert (rig.get("io1", "6200:01"), rig.get("io2", "6200:04")) == (0, 0)
    rig.set("card", "state", "run")
    rig.run_until(3_300 * MS)
    assert (rig.get("io1", "6200:01"), rig.get("io2", "6200:04")) == (1, 0x80)


@pytest.mark.long
@pytest.mark.manual("ARP-001", "ARP-002")
def test_the_motor_is_where_the_program_sent_it(rig: Rig) -> None:
    assert rig.get("card", "axis1.position") == 500.0
    assert rig.get("motor", "position") == pytest.approx(3.14159265, abs=0.001)


@pytest.mark.long
def test_the_same_rig_gives_the_same_numbers(tmp_path: Path) -> None:
    seen = []
    for _ in range(2):
        with Rig(from_dict(cell(tmp_path), tmp_path)) as rig:
            rig.run_until(1_000 * MS)
            seen.append([rig.get("card", key) for key in ("axis1.speed", "axis1.error", "dac1", "cycles", "V100")])
    assert seen[0] == seen[1]


@pytest.mark.manual("ARP-011")
@pytest.mark.parametrize("kbaud", [125, 250, 500, 1000])
def test_the_bit_rate_is_taken_at_power_on(kbaud: int) -> None:
    bench = CardBench(parameters={"general": {6: kbaud}}, with_can=True)
    assert [message for message in bench.can.take() if isinstance(message, BitRate)] == [BitRate(kbaud * 1_000)]
    bench.access.save_parameter(0, 6, 125_000)
    bench.run_for(20).drive("I108", False).run_for(20).drive("I108", True).run_for(20)
    assert not any(isinstance(message, BitRate) for message in bench.can.take())
