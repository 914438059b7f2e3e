"""Object tree, configuration and parameter files, boot and memory."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from max4_bench import Bench

from fieldrig.errors import ConfigError, ControlError, RigError
from fieldrig.storage.store import MemoryStore
from fieldrig_devices.iec.dialect import EPAS_4
from fieldrig_devices.max4.configuration.files import configuration_of_file, parameters_of_file
from fieldrig_devices.max4.configuration.limits import limits_of
from fieldrig_devices.max4.configuration.tree import Access, Object
from fieldrig_devices.max4.configuration.version import Version, goes_with, version_of
from fieldrig_devices.max4.storage.disk import FlashDisk


@pytest.mark.manual("PD-020")
@pytest.mark.manual("PD-021")
@pytest.mark.manual("PD-138")
@pytest.mark.manual("PD-334")
def test_the_least_controller_has_seven_groups() -> None:
    root = Bench().run(100).max4.firmware.tree.root
    assert list(root.groups) == ["General", "Diagnosis", "Versions"]
    assert [child.type_name for child in root.children] == ["RTBUS", "D_OUT_GROUP", "D_IN_GROUP", "M_IN_GROUP"]
    assert [list(child.children) for child in root.children] == [[], [], [], []]


@pytest.mark.manual("PD-020")
@pytest.mark.manual("PD-138")
def test_drives_are_children_of_the_real_time_bus() -> None:
    bench = Bench(simulated=("belt", "knife"), inputs={"I_bStart": ""}, logic_encoders=["MasterEncoder"]).run(100)
    root = bench.max4.firmware.tree.root
    bus, _, inputs, *_ = root.children
    assert [(child.type_name, child.symbol) for child in bus.children] == [("MC_4", "belt"), ("MC_4", "knife")]
    assert [(child.type_name, child.symbol) for child in inputs.children] == [("D_IN", "I_bStart")]
    assert bench.max4.firmware.tree.object("MasterEncoder") in root.children


@pytest.mark.manual("PD-334")
def test_group_versions_shows_what_the_controller_is() -> None:
    identity = {"article_number": "13130237", "serial_number": "0000012345", "hardware_code": "0700"}
    bench = Bench(identity=identity, version="V00.15.00").run(100)
    group = bench.max4.firmware.tree.root.groups["Versions"]
    shown = {name: parameter.value for name, parameter in group.parameters.items()}
    assert shown == {
        "SoftwareVersion": "V00.15.00",
        "ProductName": "MAx-4",
        "ArticleNumber": "13130237",
        "SerialNumber": "0000012345",
        "HardwareCode": "0700",
    }
    assert {name: bench.get(name) for name in shown} == shown
    assert not any(parameter.is_writable for parameter in group.parameters.values())


@pytest.mark.manual("PD-022")
@pytest.mark.manual("PD-024")
def test_objects_have_default_and_symbolic_names() -> None:
    bench = Bench(simulated=("conveyer_belt",), outputs={"O_bEquipmentOnIndicatorH1": ""}, inputs={"I_bStartS1": ""})
    tree = bench.run(100).max4.firmware.tree
    output = tree.object("O_bEquipmentOnIndicatorH1")
    assert (output.name, output.type_name) == ("output_0", "D_OUT")
    assert tree.object("MAX-4.digital output group.OUTPUT_0") is output
    assert tree.object("conveyer_belt").type_name == "MC_4"
    tree.set("O_bEquipmentOnIndicatorH1.Value", True)
    assert bench.get("O_bEquipmentOnIndicatorH1.Value") is True
    assert tree.get("PacDriveM.Timer1") == tree.get("MAx-4.Diagnosis.Timer1")


@pytest.mark.manual("PD-025")
@pytest.mark.manual("PD-136")
def test_logical_addresses_are_unique_and_not_ring_addresses() -> None:
    bench = Bench(simulated=("belt", "knife"), logic_encoders=["MasterEncoder"]).run(100)
    tree = bench.max4.firmware.tree
    objects = [found.log_adr for found in tree.objects()]
    parameters = [parameter.address for _, parameter in tree.parameters()]
    assert len({*objects, *parameters}) == len(objects) + len(parameters)
    assert tree.object("_belt").log_adr == bench.get("belt.logAdr") != bench.get("belt.RealTimeBusAdr")
    found = tree.by_address(bench.axis("knife").log_adr)
    assert isinstance(found, Object)
    assert found.symbol == "knife"
    assert tree.by_address(tree.parameter("MAx-4.General.MsgFilter").address) is tree.parameter("PacDriveM.MsgFilter")


@pytest.mark.manual("PD-026")
@pytest.mark.manual("PD-028")
def test_start_values_are_in_the_parameter_file() -> None:
    bench = Bench(parameters={"MAx-4.General.MsgFilter": 0x0003}, project="LINE1").run(100)
    assert bench.get("MsgFilter") == 3
    bench.set("MsgFilter", 0xFFFF)
    assert parameters_of_file(bench.max4.firmware.disk.read("\\LINE1.PAR"))["MAx-4.General.MsgFilter"] == 3
    bench.do("system reset").run(100)
    assert bench.get("MsgFilter") == 3, "the start value"
    bench.set("MsgFilter", 0x0007).do("save parameters").do("system reset").run(100)
    assert bench.get("MsgFilter") == 7
    assert {parameter.access for _, parameter in bench.max4.firmware.tree.parameters()} == {
        Access.INPUT,
        Access.INPUT_INIT,
        Access.OUTPUT,
    }


@pytest.mark.manual("PD-027")
def test_objects_come_and_go_with_a_reset() -> None:
    bench = Bench(simulated=("belt",)).run(100)
    bench.do("add mc_4 knife 2").do("add encoder MasterEncoder").do("delete belt")
    assert list(bench.max4.firmware.axes) == ["belt"]
    assert bench.get("reset_needed") is True
    bench.do("system reset").run(4_000)
    assert list(bench.max4.firmware.axes) == ["knife"]
    assert bench.get("MasterEncoder.Position") == 0
    assert bench.get("reset_needed") is False
    assert configuration_of_file(bench.max4.firmware.disk.read("\\TEST.SCF")).logic_encoders == ["MasterEncoder"]
    assert list(Bench(simulated=("belt",), store=bench.store).max4.firmware.axes) == ["knife"], "the file stays"


def test_another_rig_file_is_put_onto_the_disk() -> None:
    bench = Bench(simulated=("belt",)).run(100)
    assert list(Bench(simulated=("roll",), store=bench.store).max4.firmware.axes) == ["roll"]


@pytest.mark.parametrize(
    "words",
    [
        "",
        "login x",
        "add mc_4 knife 999",
        "add mc_4 knife two",
        "add mc_4 belt2 100",
        "delete knife",
        "save log RUN",
        "start",
    ],
)
def test_wrong_words_are_refused(words: str) -> None:
    bench = Bench(simulated=("belt",)).run(100)
    with pytest.raises(ControlError):
        bench.do(words)
    assert (bench.codes(), bench.get("reset_needed")) == ([8002, 8003], False)


@pytest.mark.manual("PD-030")
def test_a_simulated_drive_needs_nothing_else() -> None:
    bench = Bench(simulated=("belt",)).run(100).enable("belt")
    assert (bench.get("belt.AxisState"), bench.get("belt.MC4State")) == (3, 0x21)
    assert bench.axis("belt").is_controlled


@pytest.mark.parametrize(
    "wrong",
    [
        {"more_drives": {"a": {"ring_address": 1}, "b": {"ring_address": 1}}},
        {"more_drives": {"a": {"ring_address": 1}}, "inputs": {"A": ""}},
        {"more_drives": {f"a{number}": {"ring_address": number} for number in range(1, 42)}},
        {"more_drives": {"a__b": {"ring_address": 1}}},
        {"version": "0.15"},
        {"cycle_ms": 3},
        pytest.param({"diagnosis_classes": {6317: 0}}, marks=pytest.mark.manual("PD-097", "PD-098")),
        pytest.param({"diagnosis_classes": {6317: 9}}, marks=pytest.mark.manual("PD-097", "PD-098")),
    ],
)
def test_what_does_not_fit_together_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigError):
        Bench(**wrong)  # type: ignore[arg-type]  # that is the point


@pytest.mark.manual("PD-002")
def test_limit_of_axes_can_be_raised_to_47() -> None:
    axes = {f"a{number}": {"ring_address": number, "simulated": True} for number in range(1, 48)}
    assert len(Bench(more_drives=axes, max_axes=47).run(100).max4.firmware.axes) == 47


@pytest.mark.parametrize("path", ["MAx-4.General.Nothing", "MAx-4.Diagnosis.DiagCode", "belt.Position"])
def test_start_values_for_nothing_are_refused(path: str) -> None:
    with pytest.raises(RigError, match=path.split(".")[-1]):
        Bench(simulated=("belt",), parameters={path: 1})


@pytest.mark.parametrize(
    ("key", "value"), [("MsgFilter", 65_536), ("MsgFilter", "all"), ("CycleTime", 3), ("DiagCode", 1)]
)
def test_wrong_values_of_parameters_are_refused(key: str, value: int | str) -> None:
    with pytest.raises(ControlError):
        Bench().run(100).set(key, value)


# ---- boot


@pytest.mark.manual("PD-040")
@pytest.mark.parametrize(
    ("settings", "stamps"), [({}, [(1, 8002), (57, 8003)]), ({"boot": {"finished_ms": 72}}, [(1, 8002), (72, 8003)])]
)
def test_boot_has_its_two_entries(settings: dict[str, object], stamps: list[tuple[int, int]]) -> None:
    """Acceptance 1."""
    bench = Bench(**settings).run(200)  # type: ignore[arg-type]  # settings
    assert [(entry.stamp_ms, entry.code) for _, entry in bench.max4.firmware.logger.entries()][::-1] == stamps


def empty_program(folder: Path) -> str:
    file = folder / "empty.st"
    file.write_text("PROGRAM PLC_PRG\nEND_PROGRAM\n")
    return str(file)


@pytest.mark.manual("PD-041")
def test_autostart_has_its_entries_before_the_end_of_the_boot(tmp_path: Path) -> None:
    bench = Bench(program=empty_program(tmp_path), autostart=True).run(200)
    stamps = [(entry.stamp_ms, entry.code) for _, entry in bench.max4.firmware.logger.entries()][::-1]
    assert stamps == [(1, 8002), (92, 8004), (92, 8005), (98, 8003)]
    assert bench.get("program") == "running"


@pytest.mark.manual("PD-042")
def test_without_autostart_the_program_waits_for_start(tmp_path: Path) -> None:
    bench = Bench(program=empty_program(tmp_path)).run(200)
    assert bench.get("program") == "stopped"
    bench.do("start")
    assert (bench.get("program"), bench.codes()[-1]) == ("running", 8004)


@pytest.mark.manual("PD-045")
@pytest.mark.manual("PD-054")
def test_reset_closes_the_run_and_the_clock_begins_again() -> None:
    bench = Bench().run(5_000).do("system reset").run(1)
    assert bench.codes()[-2:] == [8016, 8002]
    assert bench.max4.firmware.logger.entries()[0][1].stamp_ms == 1


@pytest.mark.manual("PD-054")
def test_power_off_is_followed_by_a_boot() -> None:
    bench = Bench(outputs={"O_bH1": "lamp"}, simulated=("belt",)).run(100).set("O_bH1.Value", True).enable("belt")
    bench.fault("max4", what="power_off", duration_ms=500)
    assert (bench.get("power"), bench.get("led.power"), bench.get("O_bH1.Value")) == (False, "off", False)
    assert not bench.axis("belt").is_operating
    with pytest.raises(ControlError):
        bench.do("login")
    bench.run(600)
    assert bench.get("power") is True
    assert bench.codes() == [8002, 8003, 8002, 8003]
    assert [value for _, name, value in bench.wires if name == "lamp"] == [False, True, False, False]


# ---- memory


@pytest.mark.manual("PD-048")
@pytest.mark.parametrize(("days", "is_kept"), [(6.9, True), (7.5, False)])
def test_nvram_has_1_kb_for_7_days(days: float, is_kept: bool) -> None:
    bench = Bench().run(100).set("nvram", "1022:ab cd")
    with pytest.raises(ControlError):
        bench.set("nvram", "1023:ab cd")
    number = bench.fault("max4", what="power_off", days=days)
    bench.heal("max4", number).run(100)
    assert str(bench.get("nvram")).endswith("abcd") is is_kept
    assert (bench.get("DiagCode") == 7567) is not is_kept


def test_memory_that_fails_is_reported_and_empty() -> None:
    bench = Bench().run(100).set("nvram", "0:ab")
    bench.fault("max4", what="memory_lost")
    assert str(bench.get("nvram")).startswith("00")
    assert bench.codes() == [7567]


@pytest.mark.manual("PD-031")
def test_retain_init_clears_the_nvram() -> None:
    bench = Bench().run(100).set("nvram", "0:ab").do("system reset").run(100)
    assert str(bench.get("nvram")).startswith("ab")
    bench.set("RetainInit", True).do("save parameters").do("system reset").run(100)
    assert str(bench.get("nvram")).startswith("00")


@pytest.mark.manual("PD-046")
def test_disk_keeps_files_and_says_how_much_is_free() -> None:
    bench = Bench(disk_bytes=65_536).run(100)
    free = int(bench.get("Diskfree"))
    bench.max4.firmware.disk.write("\\index.htm", b"x" * 513)
    assert bench.get("Diskfree") == free - 1024
    assert bench.codes()[-1] == 8010
    assert Bench(disk_bytes=65_536, store=bench.store).max4.firmware.disk.read("\\INDEX.HTM") == b"x" * 513
    with pytest.raises(ValueError, match="the flash disk is full"):
        bench.max4.firmware.disk.write("\\BIG.BIN", bytes(70_000))
    with pytest.raises(ValueError, match="expected a file name"):
        bench.max4.firmware.disk.write("BIG.BIN", b"")


@given(st.binary(max_size=200))
def test_a_disk_of_rubbish_is_empty(blob: bytes) -> None:
    assert FlashDisk(MemoryStore(blob), 100_000).names == []


@given(st.binary(max_size=100) | st.text(max_size=100).map(str.encode))
def test_files_of_rubbish_are_refused(data: bytes) -> None:
    for read in (configuration_of_file, parameters_of_file):
        try:
            read(data)
        except ValueError:
            continue


def test_a_damaged_configuration_boots_with_the_least_and_says_so() -> None:
    bench = Bench(simulated=("belt",)).run(100)
    bench.max4.firmware.disk.write("\\TEST.SCF", b"{}x")
    bench.do("system reset").run(100)
    assert (list(bench.max4.firmware.axes), bench.get("DiagCode"), bench.get("DiagExtCode")) == ([], 2566, "\\TEST.SCF")


# ---- versions and limits


@pytest.mark.manual("PD-330")
@pytest.mark.parametrize(("text", "version"), [("V00.15.03", (0, 15, 3)), ("MC-4 V01.02", (1, 2, 0))])
def test_versions_have_three_parts(text: str, version: tuple[int, int, int]) -> None:
    assert version_of(text) == version
    assert str(Version(0, 15, 3)) == "V00.15.03"


# upper, lower, whether they go together (manual 6191-6207; acceptance 12)
MATRIX = [
    ("V00.15.00", "V00.15.09", True),
    ("V00.15.00", "V00.07.00", True),
    ("V00.15.09", "V00.16.00", False),
    ("V01.15.00", "V00.15.00", False),
    ("V00.15.00", "V01.07.00", False),
]


@pytest.mark.parametrize(("upper", "lower", "fits"), MATRIX)
def test_versions_go_together_by_the_matrix(upper: str, lower: str, fits: bool) -> None:
    assert goes_with(version_of(upper), version_of(lower)) is fits


@pytest.mark.manual("PD-331")
@pytest.mark.parametrize(("upper", "lower", "fits"), MATRIX)
def test_a_tool_that_is_too_old_is_refused(upper: str, lower: str, fits: bool) -> None:
    bench = Bench(version=lower).run(100)
    if fits:
        assert bench.do(f"login {upper}").codes()[-1] == 8007
    else:
        with pytest.raises(ControlError, match="EPAS-4"):
            bench.do(f"login {upper}")


def test_system_data_of_chapter_9() -> None:
    limits = limits_of(Version(0, 15))
    assert (limits.tasks, limits.code, limits.variables) == (64, 2_097_152, 1_900_544)
    assert (limits.area, limits.stack, limits.if_depth, EPAS_4.bit_address_bytes) == (65_536, 10_240, 15, 4096)


@pytest.mark.manual("PD-335")
@pytest.mark.parametrize(
    ("version", "data", "variable"),
    [
        ((0, 6, 99), 1_048_576, 32_768),
        ((0, 7, 0), 2_097_152, 32_768),
        ((0, 11, 99), 2_097_152, 32_768),
        ((0, 12, 0), 2_097_152, 131_072),
    ],
)
def test_limits_that_came_with_versions(version: tuple[int, int, int], data: int, variable: int) -> None:
    limits = limits_of(Version(*version))
    assert (limits.data, limits.variable) == (data, variable)


@pytest.mark.manual("PD-043")
def test_a_download_that_is_begun_again_or_reset_writes_no_more_of_the_first() -> None:
    bench = Bench().boot().do("download").run(1_000)
    bench.do("download").run(10_000)
    assert bench.codes().count(8010) == 1 + 7
    bench.do("download").run(1_000).do("system reset").run(10_000)
    assert bench.codes().count(8010) == 1 + 7 + 1


@pytest.mark.manual("PD-046")
def test_a_file_may_be_written_over_on_a_disk_that_is_nearly_full() -> None:
    bench = Bench(disk_bytes=65_536).run(100)
    disk = bench.max4.firmware.disk
    disk.write("\\BIG.LOG", bytes(40_000))
    with pytest.raises(ValueError, match="the flash disk is full"):
        disk.write("\\OTHER.LOG", bytes(40_000))
    disk.write("\\BIG.LOG", b"1" * 40_000)
    assert disk.read("\\BIG.LOG") == b"1" * 40_000
