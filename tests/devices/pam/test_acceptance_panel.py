"""Cases of section 19 of the digest about displays, messages, the fatal error panel and ports, on a whole machine."""

from pathlib import Path
from typing import Any

import pytest
from pam_cases import Machine
from pam_ports import GROUP, RS422, SIMATIC, VME, compiled
from pam_programs import HEADER

from fieldrig.clock import MS, S
from fieldrig.pytest_plugin import RigMaker
from fieldrig.virtual.rig import Rig
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.pam.language.ports import ports_of
from fieldrig_devices.pam.ports.masters.rs422 import Rs422Master

pytestmark = pytest.mark.long

OUTPUTS = """
D7SEG_OUTPUT D7S_A; NODE = NOD_Io; DIGITS = 1; FONT = HEXA; ADDRESS = 1; END
BINARY_OUTPUT SBO_8; NODE = NOD_Io; ADDRESS = 108; ACTIVE = HIGH; END
"""


def levels(machine: Machine, point: str, count: int, every_ms: int) -> list[object]:
    found: list[object] = []
    for _ in range(count):
        found.append(machine.rig.get("nod_io", point))
        machine.wait(every_ms / 1000)
    return found


@pytest.mark.manual("PAMS-041")
def test_t13_a_led_and_a_display_blink_for_five_seconds(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """D7S_A <- display("A"); LED_A <- set; D7S_A <- blink; LED_A <- blink; IWV_Step <- 2; WAIT_TIME 5000;
        LED_A <- no_blink; D7S_A <- no_blink;""",
        OUTPUTS,
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)
    machine.wait(0.25)
    assert levels(machine, "led1", 8, 500) == [True, False] * 4  # 1 Hz, half of the time
    assert levels(machine, "display.segments", 1, 500) != levels(machine, "display.segments", 1, 0)
    assert machine.rig.get("nod_io", "display") == "A"
    machine.wait(0.2)
    machine.until("IWV_Step", 9)
    machine.wait(0.1)
    assert levels(machine, "led1", 8, 125) == [True] * 8  # it returns to its state
    assert levels(machine, "display.segments", 8, 125) == ["abcefg"] * 8


@pytest.mark.manual("PAMS-042", "PAML-105")
@pytest.mark.parametrize(
    ("function", "shown"),
    [('display("P")', "P"), ("display(7, 1)", "7"), ("display(8000/1000, 1)", "8"), ("display(4660, 1)", "4")],
)
def test_t14_a_display_shows_a_character_or_the_last_hexadecimal_digit(
    tmp_path: Path, function: str, shown: str
) -> None:
    machine = Machine(tmp_path, f"D7S_A <- {function};", OUTPUTS).go(0.1)
    assert machine.rig.get("nod_io", "display") == shown


@pytest.mark.manual("PAMS-043")
def test_t15_an_output_is_inverted_every_500_ms_until_the_stop_key(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        "IWV_Step <- 2; LOOP SBO_8 <- invert; WAIT_TIME 500; END_LOOP BOL_StopKey;",
        OUTPUTS + "BOOLEAN BOL_StopKey; EQUATION = !IFV_Go; END_BOOLEAN\n",
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)
    machine.wait(0.25)
    assert levels(machine, "out108", 5, 500) == [True, False] * 2 + [True]
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 9)
    assert levels(machine, "out108", 4, 300) == [machine.rig.get("nod_io", "out108")] * 4


@pytest.mark.manual("PAMS-045", "PAMS-046")
def test_t16_a_message_has_its_number_in_hexadecimal(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        'IWV_Code <- 33; PamDisplay <- message(DEF_TracePointNb, "Reached trace point No:", IWV_Code);',
        "#define DEF_TracePointNb 12    // Debug trace point reached\n",
    ).go(0.1)
    assert machine["display"] == "0080M00C"
    printed = str(machine["messages"])
    assert "[0080M00C]" in printed
    assert "Reached trace point No:" in printed


@pytest.mark.manual("PAMS-046", "PAMS-047")
def test_t17_a_warning_ends_and_two_seconds_later_the_name_scrolls(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """PamDisplay <- warning(DEF_ZeroValue, "Speed is nul at location:", 127); IWV_Step <- 2; CONDITION !IFV_Go;
        PamDisplay <- end_warning(DEF_ZeroValue, "Speed is okay at location:", 127);""",
        "#define DEF_ZeroValue      23\n",
    ).go(5.0)
    assert machine["display"] == "0080W017"
    machine["IFV_Go"] = False
    machine.until("IWV_Step", 9)
    assert "[0080K017]" in str(machine["messages"])
    machine.wait(1.9)
    assert machine["display"] == "0080W017"
    machine.wait(0.2)
    assert machine["display"] != "0080W017"


@pytest.mark.manual("PAMS-046", "PAMS-047")
def test_t18_an_end_with_another_number_does_not_end_an_error(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """PamDisplay <- error(DEF_ZeroDiv, "Division by zero at location:", 56);
        PamDisplay <- end_error(DEF_EndShortCircuit, "CC end on output No:", 3);""",
        "#define DEF_ZeroDiv 6\n#define DEF_EndShortCircuit 7\n",
    ).go(5.0)
    assert (machine["display"], machine["display.blinks"]) == ("0080E006", True)
    assert str(machine["errors"]).splitlines() == ["0080E006", "0080S007"]


@pytest.mark.manual("PAMS-047", "PAMS-098")
def test_t19_the_display_blinks_until_the_host_of_the_rs422_line_starts(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        "",
        GROUP + RS422.replace("= 20000", "= 2000"),
        line="{kind: serial.virtual, baud: 38400}",
    )
    link = machine.rig.attach("host").link("line")
    machine.wait(2.1)
    assert (machine["display"], machine["display.blinks"]) == ("0780E039", True)
    assert "[0780E039] real time Error" in str(machine["messages"])
    master = Rs422Master(ports_of(compiled(GROUP + RS422))[0].variables, link.send)
    link.on_receive(master.receive)
    master.begin(machine.rig.now_ns)
    for _ in range(60):
        machine.wait(0.05)
        master.poll(machine.rig.now_ns)
    assert master.is_running
    assert "[0780S039] real time Error Canceled" in str(machine["messages"])
    shown = set()
    for _ in range(30):
        machine.wait(0.05)
        master.poll(machine.rig.now_ns)
        shown.add(str(machine["display"]).strip())
    assert not machine["display.blinks"]
    assert not any("E039" in text for text in shown)


def cells(rig: Rig, byte: int) -> str:
    """Read the seven cells of a panel by Modbus."""
    client, answers = rig.attach("client").link("vme"), list[bytes]()
    client.on_receive(lambda message: answers.append(message.pdu) if isinstance(message, ModbusResponse) else None)
    client.send(ModbusRequest(1, b"\x03" + (byte // 2).to_bytes(2, "big") + b"\x00\x07"))
    rig.run_until(rig.now_ns + 10 * MS)
    return answers[0][2:].hex(" ", 2)


def with_port(make: RigMaker, folder: Path, port: str, more: dict[str, Any] | None = None, **keys: Any) -> Rig:
    """Return a PAM with a DualPort behind Modbus; `more` are further devices, and `keys` further settings."""
    (folder / "app.pam").write_text(HEADER + GROUP + port)
    pam = {
        "kind": "pam",
        "application": str(folder / "app.pam"),
        "date": "1995-10-15 14:30:45",
        "links": {"ring": "ring", "modbus": ["vme"]},
        **keys,
    }
    buses = {"ring": {"kind": "pamring.virtual"}, "vme": {"kind": "modbus.virtual"}}
    return make({"time": "virtual", "buses": buses, "devices": {"pam": pam, **(more or {})}})


@pytest.mark.manual("PAMS-057", "PAMS-058", "PAMS-060", "PAMS-068", "PAMS-092")
@pytest.mark.parametrize(
    ("port", "wait_s", "byte"), [(VME, 0.5, 44), (SIMATIC.replace("= 20000", "= 2000"), 2.0, 0xFF0)]
)
def test_t23_a_host_that_is_not_ready_is_in_the_panel(
    fieldrig_rig: RigMaker, tmp_path: Path, port: str, wait_s: float, byte: int
) -> None:
    rig = with_port(fieldrig_rig, tmp_path, port)
    rig.run_until(round((wait_s + 0.6) * S))
    assert (rig.get("pam", "display"), rig.get("pam", "led")) == ("0780F020", "on")
    origin, number, date, time, *rest = cells(rig, byte).split()
    seconds = 45 + int(wait_s)
    assert (origin, number, date, rest) == ("0007", "0020", "169f", ["0000"] * 3)
    assert 0 <= int(time, 16) - (2 << 12 | 30 << 6 | seconds) <= 1  # 2:30 PM


@pytest.mark.manual("PAMS-060", "PAMS-070", "PAMS-107")
def test_an_unknown_output_of_the_master_is_an_error(fieldrig_rig: RigMaker, tmp_path: Path) -> None:
    master = tmp_path / "master.pam"
    master.write_text(HEADER + GROUP + VME.replace("END_DUALPORT", "OUTPUT FLAG_VAR DFO_Other ; END END_DUALPORT"))
    plc = {"kind": "pam.vme-master", "application": str(master), "links": {"modbus": "vme"}}
    rig = with_port(fieldrig_rig, tmp_path, VME, {"plc": plc})
    rig.run_until(S)
    assert (rig.get("pam", "state"), rig.get("pam", "display")) == ("running", "0780E028")
    assert rig.get("plc", "mistakes") == "the PAM does not know the output DFO_Other"
    assert cells(rig, 44)[:9] == "0000 0000"


PARAMETERS = """
INTERNAL WORD_VAR IWV_Ready; INTERNAL WORD_VAR IWV_Inactive; INTERNAL WORD_VAR IWV_Serial; INTERNAL WORD_VAR IWV_Watch;
"""


@pytest.mark.manual("PAMS-084", "PAMS-099")
def test_t31_programs_read_and_write_the_time_outs_of_ports(tmp_path: Path) -> None:
    machine = Machine(
        tmp_path,
        """IWV_Ready <- DualPort:MASTER_READY_TIMEOUT; IWV_Step <- 2; WAIT_TIME( DualPort:MASTER_INACTIVITY_TIMEOUT);
        DualPort:MASTER_INACTIVITY_TIMEOUT <- 300; RS422Port:MASTER_INACTIVITY_TIMEOUT <- 70000;
        RS422Port:PAM_WATCHDOG_MESSAGE_PERIOD <- 90;
        IWV_Inactive <- DualPort:MASTER_INACTIVITY_TIMEOUT; IWV_Serial <- RS422Port:MASTER_INACTIVITY_TIMEOUT;
        IWV_Watch <- RS422Port:PAM_WATCHDOG_MESSAGE_PERIOD;""",
        GROUP + VME + RS422 + PARAMETERS,
        keys="    ports: {without_master: true}\n",
    )
    machine["IFV_Go"] = True
    machine.until("IWV_Step", 2)
    assert machine.until("IWV_Step", 9) == pytest.approx(0.5, abs=0.003)
    names = ("IWV_Ready", "IWV_Inactive", "IWV_Serial", "IWV_Watch")
    assert [machine[name] for name in names] == [500, 300, 70_000, 90]


MOVING = """AXI_A[all] <- run(360.0); CONDITION AXI_A[all*] ? ready; IWV_Step <- 2;
    CONDITION IFV_Seen;"""


@pytest.mark.manual("PAMS-106", "PAMS-108")
@pytest.mark.parametrize(
    ("interface", "shown", "details"), [("asic", "0680F010", " 2 0 0"), ("fpga", "0680F00C", " 0 0 0")]
)
def test_a_ring_that_breaks_while_axes_move_is_fatal_and_stops_them(
    tmp_path: Path, interface: str, shown: str, details: str
) -> None:
    machine = Machine(
        tmp_path,
        MOVING,
        keys=f"    ring: {{interface: {interface}}}\n",
    ).go(1.0)
    assert machine["IWV_Step"] == 2
    assert [machine.rig.get(f"nod_a_{number}", "speed") for number in (1, 2)] == pytest.approx([1.0, 1.0], abs=0.01)
    machine.rig.add_fault("pamring", {"what": "break", "after": "nod_a_1"})
    machine.wait(1.0)
    assert (machine["state"], machine["display"], machine["led"]) == ("fatal", shown, "on")
    assert str(machine["errors"]).splitlines() == [shown, "0780E013"]
    printed = str(machine["messages"]).splitlines()
    assert printed[next(at for at, line in enumerate(printed) if shown in line) + 1].endswith(details)
    for number in (1, 2):
        assert machine.rig.get(f"nod_a_{number}", "speed") == 0.0
    stopped = [machine.degrees(number, of="position") for number in (1, 2)]
    machine.wait(1.0)
    assert [machine.degrees(number, of="position") for number in (1, 2)] == stopped
