"""The CAN face of a MAx-4: nodes, the manufacturer's objects, errors; axes are simulated."""

from contextlib import nullcontext
from typing import Any

import pytest
from can_face_bench import NODE, CanFaceBench
from canopen.objectdictionary import ODArray, ODRecord, import_od
from canopen.sdo.exceptions import SdoAbortedError
from cut_store import CutStore, Killed
from full_store import FullStore
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.errors import RigError
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.eds.check import check_eds
from fieldrig_devices.canopen.eds.reader import load
from fieldrig_devices.cia402.error_register import register_of
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict
from fieldrig_devices.max4.can.errors import error_of
from fieldrig_devices.max4.can.objects import EDS, eds_text

pytestmark = pytest.mark.long


@pytest.fixture
def bench() -> CanFaceBench:
    return CanFaceBench(simulated=("belt", "knife")).run(200)


@pytest.fixture
def node(bench: CanFaceBench) -> Any:
    return bench.master()


def test_the_eds_is_what_the_tables_say_and_has_no_fault() -> None:
    assert EDS.read_text() == eds_text()
    assert [mistake for mistake in check_eds(EDS) if "no clear mapping direction" not in mistake.what] == []


# Object codes of CiA 402-2: members of one type are an array.
@pytest.mark.parametrize(
    ("indices", "kind"),
    [
        ((0x607B, 0x607D, 0x608F, 0x6091, 0x6092, 0x6099, 0x60C1, 0x60C3, 0x60E3, 0x60FE), ODArray),
        ((0x60C2, 0x60C4), ODRecord),
    ],
)
@pytest.mark.parametrize("axis", [0, 7])
def test_objects_with_sub_indices_are_arrays_or_records(indices: tuple[int, ...], kind: type, axis: int) -> None:
    dictionary = import_od(str(EDS), NODE)
    assert {index: type(dictionary[index + axis * 0x800]) for index in indices} == dict.fromkeys(indices, kind)


@pytest.mark.manual("PD-301")
def test_bit_rates_are_those_of_the_manual() -> None:
    rates = load(EDS, NODE).features.bit_rates
    assert (min(rates), max(rates)) == (20_000, 1_000_000)


@pytest.mark.manual("PD-301")
@pytest.mark.parametrize("bit_rate", [20_000, 1_000_000])
def test_face_is_a_member_of_a_bus_with_arbitration(bit_rate: int) -> None:
    """The lower identifier wins if two frames start at one instant; the other frame follows."""
    frames: list[tuple[int, CanFrame]] = []

    def on_delivery(bus: Bus[Any], delivery: Delivery[Any]) -> None:
        if bus.name == "can0":
            frames.append((delivery.time_ns, delivery.message))

    axis = {"ring_address": 1, "simulated": True}
    max4 = {"kind": "max4", "links": {"can": "can0"}, "drives": {"belt": axis}, "can_axes": {"node_ids": [NODE]}}
    buses = {"can0": {"kind": "can.virtual", "bitrate": bit_rate}}
    with Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"max4": max4}}), on_delivery) as rig:
        ends = [rig.attach(name).link("can0") for name in ("one", "other")]
        rig.run_until(500 * MS)
        assert [frame.identifier for _, frame in frames] == [0x700 + NODE]
        frames.clear()
        ends[0].send(CanFrame(0x600 + NODE, bytes.fromhex("40 00 10 00 00 00 00 00")))
        ends[1].send(CanFrame(0x001, b""))
        rig.run_until(1_000 * MS)
        assert [frame.identifier for _, frame in frames] == [0x001, 0x600 + NODE, 0x580 + NODE]
        assert frames[2][1].data == bytes.fromhex("43 00 10 00 92 01 ff ff")
        bits = (frames[1][0] - frames[0][0]) * bit_rate / S
        assert 111 <= bits <= 135 + 3  # ISO 11898-1: 111 with the gap of 3, and at most 24 stuff bits


def test_our_conformance_cases_of_objects_and_pdos_pass(bench: CanFaceBench) -> None:
    report = conform_virtual(bench.rig, "can0", Description(EDS, NODE), choose(["OD", "PDO"]))
    assert report.of(Verdict.FAILED) == []
    assert len(report.of(Verdict.PASSED)) > 20


@pytest.mark.manual("PD-302")
def test_the_controller_is_a_canopen_slave_from_its_boot_on() -> None:
    bench = CanFaceBench(simulated=("belt",))
    assert bench.run(10).take() == ["70A#00"]
    assert bench.send("60A#40 00 10 00 00 00 00 00") == ["58A#43 00 10 00 92 01 ff ff"]


@pytest.mark.manual("PD-300")
@pytest.mark.manual("PD-302")
def test_nine_axes_are_two_nodes() -> None:
    names = tuple(f"axis{place}" for place in range(1, 10))
    bench = CanFaceBench(simulated=names, can_axes={"node_ids": [10, 20]})
    assert bench.run(10).take() == ["70A#00", "714#00"]
    first, second = bench.run(200).master(10), bench.master(20)
    assert [first.sdo[0x2100 + place][6].raw for place in range(8)] == list(names[:8])
    assert (second.sdo[0x2100][6].raw, second.sdo[0x67FF].raw, second.sdo[0x6FFF].raw) == ("axis9", 0x0002_0192, 0)
    assert second.sdo[0x6841].raw == 0


@pytest.mark.parametrize(
    ("can_axes", "right"),
    [
        (
            {"node_ids": [10], "axes_per_node": 1},
            "node_ids: expected a node for each 1 axes, got nodes for 1 axes and 2 axes",
        ),
        ({"node_ids": [10], "terminals": {"belt9": {}}}, r"expected the name of an axis \(.*\), got belt9"),
        (
            {"node_ids": [10], "terminals": {"belt": {"home": "I_bHome"}}},
            "expected the name of an input or output, got I_bHome",
        ),
        ({"node_ids": [10, 10]}, "expected each node-ID once"),
        ({"node_ids": []}, "a list of 1 to 16 items"),
        ({"node_ids": [10], "objects": {"6FFE:07": 1}}, "6FFE"),
    ],
)
def test_settings_that_do_not_fit_are_refused(can_axes: dict[str, Any], right: str) -> None:
    with pytest.raises((RigError, ValueError), match=right):
        CanFaceBench(simulated=("belt", "knife"), can_axes=can_axes).run(1)


def test_a_controller_without_power_is_silent(bench: CanFaceBench) -> None:
    number = bench.rig.add_fault("max4", {"what": "power_off"})
    bench.run(50).take()
    assert bench.send("60A#40 00 10 00 00 00 00 00") == []
    bench.rig.clear_fault("max4", number)
    assert "70A#00" in bench.run(50).take()


def test_a_diagnosis_of_an_axis_at_rest_is_a_fault_two_cycles_later(bench: CanFaceBench) -> None:
    """Nothing else happens on the bus, so that only the change of the axis can wake its end on CAN."""
    for control_word in ("06", "07"):
        bench.send(f"60A#2B 40 60 00 {control_word} 00 00 00")
    bench.run(100)
    axis, states = bench.axis("belt"), []
    for code in (0, 3117):
        if code:
            bench.max4.firmware.reports.report_axis(code, axis)
        bench.run(2 * bench.max4.firmware.cycle_ns / MS)
        states.append(int(bench.send("60A#40 41 60 00 00 00 00 00")[-1].split()[4], 16) & 0x4F)
    assert states == [0x03, 0x08]  # switched on, fault


def test_diagnosis_messages_and_quitting(bench: CanFaceBench, node: Any) -> None:
    assert (node.sdo[0x2000][1].raw, node.sdo[0x2000][3].raw, node.sdo[0x2000][5].raw) == (0, "", 1)
    bench.rig.set("max4", "RetainInit", True)
    node.sdo[0x2001][1].raw = 1
    newest = node.sdo[0x2001][2].raw
    assert newest == bench.max4.firmware.logger.lines()[0]
    assert node.sdo[0x2001][3].raw == len(bench.max4.firmware.logger)
    node.sdo[0x2001][1].raw = 1000
    with pytest.raises(SdoAbortedError) as refused:
        _ = node.sdo[0x2001][2].raw
    assert refused.value.code == 0x0800_0024
    node.sdo[0x2000][4].raw = 1


def test_parameters_by_path_and_logical_address(bench: CanFaceBench, node: Any) -> None:
    window = node.sdo[0x2002]
    window[2].raw = "MAx-4.General.MsgFilter"
    parameter = bench.max4.firmware.tree.parameter("MAx-4.General.MsgFilter")
    assert (window[1].raw, window[4].raw, window[5].raw) == (parameter.address, 65_535.0, "65535")
    assert (window[3].raw, window[6].raw) == (3, 1)  # UINT, with user initialisation
    window[4].raw = 255.0
    assert parameter.value == 255
    window[5].raw = "511"
    assert parameter.value == 511
    window[1].raw = bench.max4.firmware.tree.parameter("belt.Position").address
    assert window[2].raw.endswith("belt.General.Position")


@pytest.mark.parametrize(
    ("path", "value", "code"),
    [
        ("MAx-4.General.MsgFilter", -1.0, 0x0609_0030),
        ("MAx-4.General.MsgFilter", 1.5, 0x0609_0030),
        ("MAx-4.General.MsgFilter", float("nan"), 0x0609_0030),
        ("belt.Position", 1.0, 0x0601_0002),
    ],
)
def test_values_that_a_parameter_can_not_have_are_refused(node: Any, path: str, value: float, code: int) -> None:
    node.sdo[0x2002][2].raw = path
    with pytest.raises(SdoAbortedError) as refused:
        node.sdo[0x2002][4].raw = value
    assert refused.value.code == code


def test_the_first_parameter_is_shown_at_first(node: Any) -> None:
    assert node.sdo[0x2002][2].raw == "MAx-4.General.MsgFilter"


def test_what_there_is_not_has_no_address(node: Any) -> None:
    for sub, value in ((1, 0x7FFF_0001), (2, "belt.Nothing")):
        with pytest.raises(SdoAbortedError) as refused:
            node.sdo[0x2002][sub].raw = value
        assert refused.value.code == 0x0609_0030


def test_each_axis_says_what_it_is(bench: CanFaceBench, node: Any) -> None:
    knife = bench.axis("knife")
    window = node.sdo[0x2101]
    assert (window[6].raw, window[7].raw, window[8].raw) == ("knife", knife.log_adr, 101)
    assert (window[4].raw, window[5].raw) == (knife.axis_state.value, knife.mc4_state)


def test_axis_2_moves_by_its_own_objects(bench: CanFaceBench, node: Any) -> None:
    node.sdo[0x6860].raw = 1
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6840].raw = word
    bench.run(200)
    node.sdo[0x687A].raw = 250_000
    node.sdo[0x6840].raw = 0x1F
    bench.run(1_000)
    assert (bench.axis("knife").position, bench.axis("belt").position) == (250_000, 0)
    assert node.sdo[0x6864].raw == 250_000


def test_who_enables_last_moves(bench: CanFaceBench, node: Any) -> None:
    """Another face that has the axis is not disturbed by a master that stops."""
    belt = bench.axis("belt")
    belt.enable(True)
    bench.run(200)
    node.sdo[0x6040].raw = 0x06
    node.sdo[0x6040].raw = 0x00
    assert belt.is_enabled


def test_switches_home_an_axis() -> None:
    terminals = {"belt": {"home": "I_bHome", "inputs": ["I_bDoor"], "outputs": ["O_bLamp"]}}
    bench = CanFaceBench(
        simulated=("belt",),
        can_axes={"node_ids": [NODE], "terminals": terminals},
        inputs={"I_bHome": "", "I_bDoor": ""},
        outputs={"O_bLamp": ""},
    ).run(200)
    node = bench.master()
    bench.rig.set("max4", "I_bDoor.Value", True)
    assert node.sdo[0x60FD].raw == 0x0001_0000
    node.sdo[0x60FE][2].raw = 0x0001_0000
    node.sdo[0x60FE][1].raw = 0x0001_0000
    assert bench.rig.get("max4", "O_bLamp.Value") is True
    node.sdo[0x6098].raw = 20
    node.sdo[0x6060].raw = 6
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6040].raw = word
    bench.run(200)
    node.sdo[0x6040].raw = 0x1F
    for is_on, ms in ((True, 400), (False, 300), (True, 200)):  # fast onto it, off, slowly onto it
        bench.run(ms)
        bench.rig.set("max4", "I_bHome.Value", is_on)
    bench.run(100)
    assert node.sdo[0x6041].raw & 0x3400 == 0x1400
    assert 0 < bench.axis("belt").position - node.sdo[0x6064].raw < 200_000


def test_inputs_are_limit_switches_and_touch_probes() -> None:
    """Axis 2, so that nothing hangs on the first one."""
    terminals = {"knife": {"positive_limit": "I_bEnd", "inputs": ["I_bProbe"]}}
    bench = CanFaceBench(
        simulated=("belt", "knife"),
        can_axes={"node_ids": [NODE], "terminals": terminals},
        inputs={"I_bEnd": "", "I_bProbe": ""},
    ).run(200)
    node = bench.master()
    node.sdo[0x6860].raw = 3
    node.sdo[0x68FF].raw = 1_000_000
    node.sdo[0x68B8].raw = 0x0011
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6840].raw = word
    bench.run(400)
    bench.rig.set("max4", "I_bProbe.Value", True)
    before = bench.axis("knife").position
    bench.run(100)
    assert before <= node.sdo[0x68BA].raw <= before + 8_000
    bench.rig.set("max4", "I_bEnd.Value", True)
    bench.run(100)
    assert (bench.axis("knife").velocity, node.sdo[0x6841].raw & 0x086F) == (0, 0x0827)
    node.sdo[0x68FF].raw = -1_000_000
    bench.run(200)
    assert bench.axis("knife").velocity == -1_000_000


@pytest.mark.parametrize("allowed", [0, 1])
def test_parameters_are_stored_in_one_step(allowed: int) -> None:
    """A process that is killed meanwhile leaves all old ones or all new ones; 1010h takes one write."""
    store = CutStore()
    bench = CanFaceBench(simulated=("belt", "knife"), store=store).run(200)
    node = bench.master()
    for index in (0x6081, 0x6085, 0x6881, 0x6885):
        node.sdo[index].raw = 12_345
    store.saves, store.allowed = 0, allowed
    with nullcontext() if allowed else pytest.raises(Killed):
        node.sdo[0x1010][1].raw = 0x65766173
    again = CanFaceBench(simulated=("belt", "knife"), store=MemoryStore(store.load())).run(200).master()
    found = [again.sdo[index].raw == 12_345 for index in (0x6081, 0x6085, 0x6881, 0x6885)]
    assert found == [bool(allowed)] * 4
    assert store.saves == allowed


def test_parameters_that_the_disk_does_not_take_are_a_hardware_error() -> None:
    store = FullStore()
    store.is_full = False
    bench = CanFaceBench(simulated=("belt", "knife"), store=store).run(200)
    node = bench.master()
    store.is_full = True
    with pytest.raises(SdoAbortedError) as refused:
        node.sdo[0x1010][1].raw = 0x65766173
    assert refused.value.code == 0x0606_0000
    store.is_full = False
    node.sdo[0x1010][1].raw = 0x65766173


def home(bench: CanFaceBench, node: Any) -> None:
    """Home by the selected method, starting without power."""
    node.sdo[0x6060].raw = 6
    for word in (0x06, 0x07, 0x0F):
        node.sdo[0x6040].raw = word
    bench.run(200)
    node.sdo[0x6040].raw = 0x1F
    bench.run(20)


def test_a_full_flash_disk_refuses_to_store_and_nothing_else_happens(bench: CanFaceBench, node: Any) -> None:
    disk = bench.max4.firmware.disk
    disk.write("\\BIG.DAT", bytes(disk.free // 512 * 512))
    names = set(disk._files)
    with pytest.raises(SdoAbortedError, match="0x06060000"):
        node.sdo[0x1010][1].raw = 0x65766173
    home(bench, node)
    assert node.sdo[0x6041].raw & 0x3400 == 0x1400  # homed, until power-off
    assert set(disk._files) == names


def test_the_origin_is_kept_over_power_off() -> None:
    bench = CanFaceBench(simulated=("belt",)).run(200)
    node = bench.master()
    node.sdo[0x607C].raw = 5_000
    home(bench, node)
    assert node.sdo[0x6064].raw == -5_000
    again = CanFaceBench(simulated=("belt",), store=bench.store).run(200)
    assert again.master().sdo[0x6064].raw == -5_000


@pytest.mark.parametrize(
    ("diag_code", "error", "register"),
    [
        (1117, 0x7305, 0x20),
        (3117, 0x4310, 0x08),
        (1108, 0x3210, 0x04),
        (2106, 0x7500, 0x10),
        (3125, 0x2350, 0x02),
        (3196, 0x8611, 0x20),
        (7134, 0x5112, 0x20),
        (2560, 0x7500, 0x10),
        (4125, 0x2350, 0x02),  # of another class
        (5999, 0xFF00, 0x80),
        (0, 0, 0x20),
    ],
)
def test_diagnoses_have_error_codes(diag_code: int, error: int, register: int) -> None:
    assert error_of(diag_code) == error
    assert register_of(error) == register


BYTES = st.binary(min_size=0, max_size=8)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(st.sampled_from([0x20A, 0x30A, 0x40A, 0x50A, 0x60A, 0x000, 0x080]), BYTES), max_size=25))
def test_whatever_comes_from_the_bus_the_controller_goes_on(frames: list[tuple[int, bytes]]) -> None:
    bench = CanFaceBench(simulated=("belt",)).run(100)
    bench.send("000#01 0A")
    for identifier, data in frames:
        bench.send(f"{identifier:03X}#{data.hex(' ')}")
    bench.send("000#81 0A")
    assert "58A#43 00 10 00 92 01 ff ff" in bench.run(100).send("60A#40 00 10 00 00 00 00 00")
