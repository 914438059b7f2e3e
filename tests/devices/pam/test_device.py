"""A PAM as a device of a rig: power, start, panel, errors and reset."""

from pathlib import Path

import pytest
from pam_rigs import pam_rig

from fieldrig.clock import MS, S
from fieldrig.errors import ConfigError
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.pam.pipes.shapes import shape_of
from fieldrig_devices.pam.settings import PamSettings

PAM = """{kind: pam, application: app.pam, date: 1995-10-15 14:30:45, links: {ring: ring, wires: wires},
    analog_wires: [pam.speed]}"""
HEADER = "APPLICATION NAME = PACKERLONGNAME V1.02 ; BASIC_PAM_CYCLE = 3 ; END\n"
COUNTER = """
PAM_ANALOG_OUTPUT PAO_Speed ; UNITS_PER_VOLT = 1000 ; OFFSET = 0 ; ADDRESS = 0 ; END
INTERNAL WORD_VAR IWV_Count ;
TASK TSK_Count ;
  SPECS CYCLES = 1 ; END_SPECS
  EVENTS ON_EVENT IWV_Count = 1 XEQ_SEQUENCE SEQ_Count ; END_EVENTS
  SEQUENCE SEQ_Count ;
    LOOP
      WAIT_TIME 100 ;
      IWV_Count <- IWV_Count + 1 ;
      PAO_Speed <- IWV_Count * 100 ;
    END_LOOP IWV_Count = 10 ;
    {end}
  END_SEQUENCE
  POWERON IWV_Count <- 1 ; END_POWERON
END_TASK
"""


@pytest.fixture
def rig(fieldrig_rig: RigMaker, tmp_path: Path) -> Rig:
    return started(fieldrig_rig, tmp_path, COUNTER.format(end=""))


def started(make: RigMaker, folder: Path, application: str, readings: str = "programs: {}") -> Rig:
    return pam_rig(make, folder, HEADER + application, pam=PAM.replace("analog_wires", f"{readings}, analog_wires"))


def with_node(make: RigMaker, folder: Path, keys: str) -> Rig:
    """Return a PAM with an input of a Smart-IO, `node`; `keys` are those of its ring."""
    node = """
NODE NOD_Io; ADDRESS = 33; TYPE = SMART_IO; END
BINARY_INPUT SBI_a; NODE = NOD_Io; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
"""
    pam = PAM.replace("analog_wires", f"ring: {{{keys}}}, analog_wires")
    further = "  node: {kind: smart_io, ring_address: 33, links: {ring: ring, wires: wires}}\n"
    return pam_rig(make, folder, HEADER + node, further, pam)


def codes(rig: Rig) -> list[str]:
    """The codes that the debugger has printed."""
    lines = str(rig.get("pam", "messages")).splitlines()
    return [line[line.index("[") + 1 : line.index("]")] for line in lines[::2]]


def test_a_cam_has_the_shape_of_its_file(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    (tmp_path / "HUMP.cam").write_text("0 0\n0.2 0.5\n0.5 1\n0.7 0.4\n1 0\n")
    application = """
SINK SNK_Values; END
PROFILE PRO_Hump; FILE = HUMP; INPUT_AMPLITUDE = 1; OUTPUT_AMPLITUDE = 1; INPUT_OFFSET = 0; OUTPUT_OFFSET = 0; END
CAM CAM_Hump; PROFILE = PRO_Hump; VALUE_RANGE = 0 1; END
CONVERTER CNV_Values; DESTINATION = SNK_Values; MODE = VALUE; END
TMP_GENERATOR TMP_Rest; TRAVEL_SPEED = 1; ACCELERATION = 1; INITIAL_POSITION = 0.1; POSITION_RANGE = 0 1;
  PERIOD = 0.001; ANTI_DELAY = NO; END
INTERNAL FLAG_VAR IFV_Go ;
INTERNAL REAL_VAR IRV_Seen ;
TASK TSK_Look ;
  SPECS CYCLES = 1 ; END_SPECS
  EVENTS ON_EVENT IFV_Go XEQ_SEQUENCE SEQ_Look ; END_EVENTS
  SEQUENCE SEQ_Look ;
    CNV_Values << CAM_Hump << TMP_Rest ;
    CONDITION CNV_Values ? ready ;
    IRV_Seen <- CAM_Hump ? value ;
  END_SEQUENCE
  POWERON IFV_Go <- set ; END_POWERON
END_TASK
"""
    rig = started(fieldrig_rig, tmp_path, application)
    rig.run_until(S)
    assert rig.get("pam", "IRV_Seen") == pytest.approx(shape_of((tmp_path / "HUMP.cam").read_bytes())(0.1))


@pytest.mark.manual("PAMS-107")
def test_start_says_what_it_does_in_order(rig: Rig) -> None:
    rig.run_until(S)
    assert codes(rig) == [
        "0780M008",  # no axis
        "0780M009",
        "0780M003",  # an empty ring
        "0780M00C",
        "0780M010",
        "0780M005",  # no DualPort
        "0780M016",
        "0780M018",
        "0780M017",
    ]
    assert rig.get("pam", "state") == "running"


@pytest.mark.manual("PAML-012")
@pytest.mark.parametrize(("thirds", "cycles"), [(3, 1000), (6, 500), (1, 3000)])
def test_basic_cycle_has_the_period_of_the_application(
    fieldrig_rig: RigMaker, tmp_path: Path, thirds: int, cycles: int
) -> None:
    header = HEADER.replace("BASIC_PAM_CYCLE = 3", f"BASIC_PAM_CYCLE = {thirds}")
    rig = pam_rig(fieldrig_rig, tmp_path, header + COUNTER.format(end=""), pam=PAM)
    rig.run_until(S)
    before = int(rig.get("pam", "cycle"))
    rig.run_until(2 * S)
    assert int(rig.get("pam", "cycle")) - before == cycles


@pytest.mark.manual("PAMS-106")
@pytest.mark.parametrize("shown_ms", [100, 700])
def test_the_ring_waits_for_a_ready_token_as_long_as_the_settings_say(
    fieldrig_rig: RigMaker, tmp_path: Path, shown_ms: int
) -> None:
    rig = with_node(fieldrig_rig, tmp_path, f"identify_ms: {shown_ms}")
    rig.add_fault("ring", {"what": "halt", "station": "node"})
    rig.run_until((shown_ms - 10) * MS)
    assert "0680F005" not in codes(rig)
    rig.run_until((shown_ms + 20) * MS)
    assert "0680F005" in codes(rig)


def test_all_times_of_the_ring_are_settings(tmp_path: Path) -> None:
    (tmp_path / "app.pam").write_text(HEADER)
    ring = {"boot_ms": 1, "identify_ms": 2, "acknowledge_ms": 3, "first_value_ms": 4, "frames_per_ms": 5}
    settings = PamSettings.model_validate({"application": "app.pam", "ring": ring}, context={"folder": tmp_path})
    limits = settings.ring_settings(6)
    times = (limits.boot_ns, limits.identify_ns, limits.acknowledge_ns, limits.first_value_ns)
    assert (times, limits.frames_per_cycle) == ((MS, 2 * MS, 3 * MS, 4 * MS), 10)


def test_names_in_another_case_need_a_setting(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    application = COUNTER.format(end="").replace("IWV_Count <- 1 ;", "iwv_count <- 1 ;")
    with pytest.raises(ConfigError, match="iwv_count is not declared here"):
        started(fieldrig_rig, tmp_path, application)
    rig = started(fieldrig_rig, tmp_path, application, "programs: {ignores_case: true}")
    rig.run_until(S)
    assert rig.get("pam", "IWV_Count") == 10


@pytest.mark.long
@pytest.mark.manual("PAML-011")
def test_the_version_follows_the_name(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = started(fieldrig_rig, tmp_path, COUNTER.format(end=""))
    seen = set()
    for instant in range(100):
        rig.run_until(instant * 100 * MS)
        seen.add(str(rig.get("pam", "display")).strip())
    assert "V1.02" in seen


@pytest.mark.long
@pytest.mark.manual("PAML-011")
def test_display_scrolls_the_significant_characters_of_the_name(rig: Rig) -> None:
    seen = set()
    for _ in range(100):
        rig.run_until(rig.now_ns + 100 * MS)
        seen.add(rig.get("pam", "display"))
    assert "PACKERLO" in seen
    assert "AME V1.0" not in seen
    assert "ONGN V1." in seen


@pytest.mark.long
@pytest.mark.manual("PAML-106")
def test_analog_output_of_the_front_drives_its_wire(rig: Rig) -> None:
    rig.run_until(2 * S)
    assert rig.get("pam", "analog.0") == pytest.approx(1.0, abs=0.005)


@pytest.mark.manual("PAMS-060", "PAML-228")
def test_fault_of_a_program_is_fatal_and_the_led_blinks(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = started(fieldrig_rig, tmp_path, COUNTER.format(end="IWV_Count <- 1 / (IWV_Count - 10) ;"))
    rig.run_until(3 * S)
    assert (rig.get("pam", "state"), rig.get("pam", "led")) == ("fatal", "blink")
    assert (rig.get("pam", "display"), rig.get("pam", "display.blinks")) == ("0200FFF2", True)
    assert "app.pam:14" in str(rig.get("pam", "fault"))
    stopped = rig.get("pam", "cycle")
    rig.run_until(4 * S)
    assert rig.get("pam", "cycle") == stopped


def test_the_fault_of_a_program_is_a_trouble_until_the_reset(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    rig = started(fieldrig_rig, tmp_path, COUNTER.format(end="IWV_Count <- 1 / (IWV_Count - 10) ;"))
    rig.run_until(3 * S)
    assert "app.pam:14" in str(rig.get("pam", "fault"))
    rig.set("pam", "reset", True)
    assert rig.get("pam", "fault") == ""


@pytest.mark.long
def test_reset_begins_again(rig: Rig) -> None:
    rig.run_until(3 * S)
    rig.set("pam", "reset", True)
    assert codes(rig) == ["0780M008", "0780M009"]
    rig.run_until(4 * S)
    assert rig.get("pam", "state") == "running"


@pytest.mark.long
def test_without_power_nothing_is_shown(rig: Rig) -> None:
    rig.run_until(S)
    number = rig.add_fault("pam", {"what": "power_off"})
    assert (rig.get("pam", "display"), rig.get("pam", "led"), rig.get("pam", "state")) == (" " * 8, "off", "off")
    rig.clear_fault("pam", number)
    rig.run_until(2 * S)
    assert rig.get("pam", "state") == "running"


def test_application_with_mistakes_is_refused_with_their_places(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as refused:
        started(fieldrig_rig, tmp_path, "INTERNAL WORD_VAR IWV_a ;\nINTERNAL WORD_VAR IWV_a ;\nfoo ;\n")
    assert "app.pam:4:1" in str(refused.value)


@pytest.mark.manual("PAMS-062")
def test_overrun_of_a_workspace_ends_the_application(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    application = COUNTER.format(end="").replace(
        "  SEQUENCE SEQ_Count ;", "  SEQUENCE SEQ_Count ;\n  SPECS WORKSPACE = 1 ; END_SPECS"
    )
    rig = started(fieldrig_rig, tmp_path, application)
    rig.run_until(S)
    assert (rig.get("pam", "state"), rig.get("pam", "display"), rig.get("pam", "led")) == ("fatal", "0380E02C", "blink")
    assert "WORKSPACE Allocated: 1 Used:" in str(rig.get("pam", "messages"))


@pytest.mark.long
@pytest.mark.manual("PAMS-044")
def test_debugger_prints_the_messages_of_the_display_and_no_monitored_value(
    fieldrig_rig: RigMaker, tmp_path: Path
) -> None:
    end = 'PAMDISPLAY <- message(12, "Counted to:", IWV_Count); WAIT_TIME 1000; PAMDISPLAY <- IWV_Count * 2.5;'
    rig = started(fieldrig_rig, tmp_path, COUNTER.format(end=end))
    rig.run_until(2 * S)
    assert rig.get("pam", "display") == "0080M00C"
    printed = rig.get("pam", "messages")
    assert "Counted to:" in str(printed)
    rig.run_until(4 * S)
    shown = str(rig.get("pam", "display"))
    assert len(shown) == 8
    assert float(shown) == 25.0
    assert rig.get("pam", "messages") == printed


@pytest.mark.long
@pytest.mark.manual("PAMS-056", "PAMS-059")
def test_only_a_fatal_error_is_in_the_fatal_error_panel(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    end = 'PAMDISPLAY <- error(1, "An error", 0) ; WAIT_TIME 500 ; IWV_Count <- 1 / (IWV_Count - 10) ;'
    (tmp_path / "app.pam").write_text(HEADER + COUNTER.format(end=end))
    rig = fieldrig_rig(
        {
            "time": "virtual",
            "buses": {"ring": {"kind": "pamring.virtual"}, "plc": {"kind": "modbus.virtual"}},
            "devices": {
                "pam": {
                    "kind": "pam",
                    "application": str(tmp_path / "app.pam"),
                    "date": "1995-10-15 14:30:43",
                    "links": {"ring": "ring", "modbus": ["plc"]},
                }
            },
        }
    )
    client, answers = rig.attach("client").link("plc"), list[bytes]()
    client.on_receive(lambda message: answers.append(message.pdu) if isinstance(message, ModbusResponse) else None)
    for instant in (S, 3 * S):  # after the error at about 0.9 s, and after the division by zero half a second later
        rig.run_until(instant)
        client.send(ModbusRequest(1, bytes.fromhex("03 07f8 0007")))  # the cells from #FF0 on
        rig.run_until(instant + 10 * MS)
    assert rig.get("pam", "errors") == "0080E001\n0200FFF2"
    assert [answer[2:].hex(" ", 2) for answer in answers] == [
        "0000 0000 0000 0000 0000 0000 0000",
        "0002 0ff2 169f 27ac 0000 0000 0000",  # 1995-10-15, 2:30:44 PM
    ]


@pytest.mark.long
@pytest.mark.manual("PAMS-060")
@pytest.mark.parametrize(
    ("node", "shown"),
    [
        ("NODE NOD_b; ADDRESS = 34; TYPE = ST1; END", "0680F003"),  # not there
        (
            "NODE NOD_b; ADDRESS = 34; TYPE = SMART_IO; END NODE NOD_c; NUMBER = 2; ADDRESS = 35; TYPE = ST1; END",
            "0680F003",
        ),
    ],
)
def test_the_display_shows_what_is_wrong_with_the_ring(
    fieldrig_rig: RigMaker, tmp_path: Path, node: str, shown: str
) -> None:
    """07..F025, that no peripheral of a NODE is there, follows."""
    further = "  node: {kind: smart_io, ring_address: 33, links: {ring: ring, wires: wires}}\n"
    text = f"{HEADER}NODE NOD_a; ADDRESS = 33; TYPE = SMART_IO; END {node}\n"
    rig = pam_rig(fieldrig_rig, tmp_path, text, further)
    rig.run_until(5 * S)
    assert "0780F025" in codes(rig)
    assert (rig.get("pam", "display"), rig.get("pam", "display.blinks")) == (shown, True)
