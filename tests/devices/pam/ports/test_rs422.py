"""The RS422 port: sessions, time-outs and values (section 13.1; T19, T30)."""

import pytest
from pam_ports import GROUP, RS422, VME, PortBench, started_rs422
from pam_programs import HEADER

from fieldrig.clock import MS, S
from fieldrig.pytest_plugin import RigMaker
from fieldrig_devices.pam.language.ports import PortVariable, crc_of
from fieldrig_devices.pam.ports.masters.rs422 import Rs422Master
from fieldrig_devices.pam.ports.rs422.codec import FramedCodec
from fieldrig_devices.pam.ports.rs422.messages import Code, Message, Result, exchange

ALIVE = bytes.fromhex("02 08 60 f8 03")


def say(bench: PortBench, code: int, *values: int) -> list[Message]:
    """Send a message to the PAM, and return what it sends within 20 ms."""
    bench.line.clear()
    bench.ports.receive(FramedCodec().encode(Message(code, values)))
    bench.cycles(20)
    found = list(FramedCodec().decode(b"".join(bench.line)))
    return [message for message in found if isinstance(message, Message)]


@pytest.mark.manual("PAMS-097", "PAMS-101", "PAMS-107")
def test_a_session() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    master = bench.connect(initial={"RWI_MachPressure": -3, "RRI_MachHeadFactor": 0.5})
    bench.cycles(300)
    assert master.is_running
    assert not master.mistakes
    assert bench.kernel.codes == ["07..M005", "07..M020", "07..M024", "07..M021", "07..M022", "07..M023"]
    assert bench.ports.states == {"RS422Port": "running"}
    assert bench.value("RWI_MachPressure") == -3
    assert [bench.value("RRI_MachHeadFactor", index) for index in range(6)] == [0.5] * 6


@pytest.mark.manual("PAMS-097", "PAMS-101")
def test_values_in_both_directions() -> None:
    bench, master = started_rs422()
    master.put("RLI_MachHeadSpeed", -70_000, 5)
    master.put("RFI_MachRunning", True)
    master.put("RRI_MachHeadFactor", 2.5, -1)
    bench.item("RWO_MachCurrentPressure").set_value(-1)
    bench.item("RLO_MachHeadPosition", 3).set_value(1 << 20)
    bench.item("RRO_MachHeadLevel", 0).set_value(0.1)
    bench.item("RFO_MachStopped").do("set", ())
    bench.item("RFO_MachStopped").do("reset", ())
    bench.cycles(40)
    assert bench.value("RLI_MachHeadSpeed", 5) == -70_000
    assert bench.value("RFI_MachRunning") is True
    assert bench.value("RRI_MachHeadFactor", 4) == 2.5
    assert master.changes == [
        ("RWO_MachCurrentPressure", 0, -1),
        ("RLO_MachHeadPosition", 3, 1 << 20),
        ("RRO_MachHeadLevel", 0, 0.1),
        ("RFO_MachStopped", 0, True),
        ("RFO_MachStopped", 0, False),
    ]


def test_inputs_are_updated_at_the_period() -> None:
    bench, master = started_rs422()
    bench.kernel.events.clear()
    bench.cycles(21 - bench.kernel.cycle_number % 20)
    for value in (1, 2, 3):
        master.put("RWI_MachPressure", value)
        bench.cycles()
    assert bench.value("RWI_MachPressure") == 0
    bench.cycles(20)
    assert (bench.value("RWI_MachPressure"), bench.kernel.events) == (3, ["RWI_MachPressure"])


@pytest.mark.manual("PAMS-098", "PAMS-100")
def test_t19_the_application_runs_without_a_master_that_comes_later() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    bench.cycles(19_999)
    assert bench.ports.may_run
    assert bench.kernel.codes == ["07..M005", "07..M020", "07..M024"]
    bench.item("RWO_MachCurrentPressure").set_value(17)  # an internal variable for the time being
    bench.cycles(40_000)
    assert bench.kernel.codes == ["07..M005", "07..M020", "07..M024", "07..E039"]  # the first time only
    master = bench.connect()
    bench.cycles(300)
    assert bench.kernel.codes[-4:] == ["07..M021", "07..M022", "07..S039", "07..M023"]
    assert master.changes == [("RWO_MachCurrentPressure", 0, 17)]


@pytest.mark.manual("PAMS-100")
def test_a_configuration_that_stops_is_given_up() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    assert say(bench, Code.REQUEST) == [Message(Code.ACK, (Code.REQUEST, Result.OK, 0, 0))]
    bench.cycles(4900)
    (definition,) = say(bench, Code.ASK_DEF_IN)
    assert definition == Message(Code.DEF_IN, (crc_of("RFI_MachRunning"), 1, 1, 1, 20))
    bench.cycles(4900)
    assert bench.ports.states == {"RS422Port": "configuring"}
    bench.cycles(100)
    assert bench.kernel.codes[-2:] == ["07..E039", "07..M024"]
    assert say(bench, Code.ASK_DEF_IN) == [Message(Code.ACK, (Code.ASK_DEF_IN, Result.REJECTED, 0, 0))]


@pytest.mark.manual("PAMS-100", "PAMS-099", "PAMS-084")
def test_a_master_that_falls_silent_is_an_error() -> None:
    bench, master = started_rs422()
    port = bench.item("RS422Port")
    bench.cycles(3000)
    assert not port.ask("error", ())  # the master is alive
    bench.master = None
    bench.cycles(1490)  # the last message may have been 500 ms ago
    assert not port.ask("error", ())
    bench.cycles(520)
    assert bench.kernel.codes[-2:] == ["07..E035", "07..M024"]
    assert (port.ask("error", ()), port.ask("error_code", (2,)), bench.kernel.events[-1]) == (True, True, "RS422Port")
    bench.master = master
    bench.cycles(3000)
    assert bench.kernel.codes[-4:] == ["07..M021", "07..M022", "07..S035", "07..M023"]
    assert not port.ask("error", ())
    port.set_parameter("MASTER_INACTIVITY_TIMEOUT", 100)  # shorter than the messages of this master
    bench.cycles(600)
    assert "07..E035" in bench.kernel.codes[-3:]


@pytest.mark.manual("PAMS-100")
def test_the_pam_says_that_it_is_alive() -> None:
    bench, _ = started_rs422()
    bench.line.clear()
    bench.cycles(2000)
    assert bench.line == [ALIVE] * 4  # PAM_WATCHDOG_MESSAGE_PERIOD is 500 ms
    bench.item("RS422Port").set_parameter("PAM_WATCHDOG_MESSAGE_PERIOD", 100)
    bench.cycles(100)
    bench.line.clear()
    for value in range(50):
        bench.item("RWO_MachCurrentPressure").set_value(value + 1)
        bench.cycles(99)
    assert ALIVE not in bench.line


@pytest.mark.manual("PAMS-107")
def test_commands_in_the_wrong_phase_and_unknown_ones() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    say(bench, Code.REQUEST)
    assert say(bench, Code.END_DEF_OUT) == [Message(Code.ACK, (Code.END_DEF_OUT, Result.REJECTED, 0, 0))]
    assert say(bench, Code.START) == [Message(Code.ACK, (Code.START, Result.REJECTED, 0, 0))]
    assert bench.kernel.codes[-1] == "07..E036"
    assert say(bench, Code.ACK, 0, 0, 0, 0) == [Message(Code.ACK, (Code.ACK, Result.BAD_COMMAND, 0, 0))]
    assert bench.kernel.codes[-1] == "07..E037"
    bench.connect()
    bench.cycles(300)
    assert "07..S036" in bench.kernel.codes


@pytest.mark.manual("PAMS-107")
def test_mistakes_in_the_configuration_are_summed_up() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    say(bench, Code.REQUEST)
    while say(bench, Code.ASK_DEF_IN)[0].code == Code.DEF_IN:
        pass
    assert say(bench, Code.DEF_OUT, 0x1234, 9)[0].values[1] == Result.BAD_CRC
    assert bench.kernel.reports[-1] == ("07..E03B", (0x1234, 9, 0))
    say(bench, Code.END_DEF_OUT)
    say(bench, Code.INIT_IN)
    assert say(bench, Code.XNG_WORD, 99, 0, 1)[0].values[1] == Result.BAD_KEY
    assert bench.kernel.reports[-1] == ("07..E03C", (99, 0xFFFF_FFFF, 0))
    assert say(bench, Code.XNG_WORD, 0, 0, 1)[0].values[1] == Result.BAD_KEY  # keys begin with 1
    assert bench.kernel.reports[-1] == ("07..E03C", (0, 0xFFFF_FFFF, 0))
    assert say(bench, Code.XNG_LONG, 4, 0, 1)[0].values[1] == Result.BAD_CLASS
    assert bench.kernel.reports[-1] == ("07..E03E", (3, 2, 0))
    for index in (1, 0xFFFF):  # of a single item, which is no item of several
        assert say(bench, Code.XNG_WORD, 4, index, 1)[0].values[1] == Result.BAD_KEY
        assert bench.kernel.reports[-1] == ("07..E03C", (4, 4, 0))
    say(bench, Code.END_INIT_IN)
    say(bench, Code.START)
    assert bench.kernel.codes[-2:] == ["07..E03D", "07..M023"]


@pytest.mark.manual("PAMS-107")
def test_faults_of_the_line() -> None:
    bench, _ = started_rs422()
    bench.master = None
    bench.ports.receive(bytes.fromhex("02 08 60 f9 03"))
    bench.cycles()
    assert bench.kernel.reports[-1] == ("07..E03A", (3, 0, 0))
    bench.ports.receive(bytes(5000))
    bench.cycles()
    assert ("07..E03A", (6, 0, 0)) in bench.kernel.reports
    bench.cycles(2000)
    assert [code for code in bench.kernel.codes if code[4] in "EW"][-2:] == ["07..W03A", "07..E035"]


@pytest.mark.manual("PAMS-107")
def test_a_fault_before_the_last_message_is_not_the_cause() -> None:
    bench, _ = started_rs422()
    bench.master = None
    bench.ports.receive(bytes.fromhex("02 08 60 f9 03") + ALIVE)
    bench.cycles(2100)
    assert "07..E03A" in bench.kernel.codes
    assert "07..W03A" not in bench.kernel.codes
    assert bench.kernel.codes[-2:] == ["07..E035", "07..M024"]


def test_nothing_is_sent_to_a_master_that_is_lost() -> None:
    bench, _ = started_rs422()
    bench.master = None
    bench.ports.receive(ALIVE)
    bench.item("RS422Port").set_parameter("MASTER_INACTIVITY_TIMEOUT", 50)
    bench.ports.receive(ALIVE)  # the new time counts from here
    for value in range(400):
        bench.item("RRO_MachHeadLevel", 0).set_value(value + 1.5)
    bench.cycles(60)
    assert bench.kernel.codes[-2:] == ["07..E035", "07..M024"]
    bench.line.clear()
    bench.cycles(500)
    assert bench.line == []


@pytest.mark.manual("PAMS-107")
def test_more_changes_than_the_line_carries() -> None:
    bench, master = started_rs422()
    for value in range(2000):
        bench.item("RRO_MachHeadLevel", value % 4).set_value(value + 1.5)
    bench.cycles(1500)
    assert bench.kernel.codes.count("07..E038") == 1
    got = [value for _, _, value in master.changes]
    assert got == sorted(got)
    assert len(got) < 2000


def test_a_reset_begins_again() -> None:
    bench, master = started_rs422()
    bench.master = None
    bench.cycles(2600)
    assert bench.item("RS422Port").ask("error", ())
    bench.master = master
    bench.cycles(2000)
    bench.cycles(21 - bench.kernel.cycle_number % 20)
    master.put("RWI_MachPressure", 5)
    bench.master = None
    bench.cycles(2)
    bench.begin()
    bench.kernel.reports.clear()
    bench.cycles(20_001)
    assert bench.value("RWI_MachPressure") == 0
    assert not bench.item("RS422Port").ask("error", ())
    assert bench.kernel.codes == ["07..E039"]


def test_a_new_request_ends_the_session() -> None:
    bench, master = started_rs422()
    master.begin(bench.now_ns)
    bench.cycles(300)
    assert master.is_running
    assert bench.kernel.codes[-3:] == ["07..M021", "07..M022", "07..M023"]


def test_a_master_with_other_definitions_uses_what_fits() -> None:
    bench = PortBench(GROUP + RS422)
    bench.begin()
    wrong = [PortVariable("RWI_MachPressure", "LONG_VAR", True), PortVariable("RFO_Other", "FLAG_VAR", False)]
    kept = [found for found in bench.variables if found.name not in ("RWI_MachPressure", "RFO_MachStopped")]
    bench.master = master = Rs422Master([*kept, *wrong], bench.ports.receive)
    master.begin(0)
    bench.cycles(500)
    assert master.is_running
    assert sorted(master.mistakes) == [
        "RWI_MachPressure has the class 2 and 1 items on the PAM",
        "the PAM does not know the output RFO_Other",
    ]
    bench.item("RFO_MachStopped").do("set", ())
    bench.cycles(20)
    assert master.changes == []


@pytest.mark.manual("PAMS-086", "PAML-029")
def test_components_that_are_not_active_are_not_serviced() -> None:
    bench, master = started_rs422()
    bench.inactive = {1}
    master.put("RFI_MachHeadReady", True, -1)
    for index in (0, 1):
        bench.item("RLO_MachHeadPosition", index).set_value(5)
    bench.cycles(40)
    assert [bench.value("RFI_MachHeadReady", index) for index in range(4)] == [True, False, True, True]
    assert master.changes == [("RLO_MachHeadPosition", 0, 5)]


def test_a_pam_with_both_ports_waits_for_the_dual_port_only() -> None:
    bench = PortBench(GROUP + VME + RS422)
    bench.begin()
    bench.cycles()
    assert bench.ports.states == {"DualPort": "synchronising", "RS422Port": "waiting for a request"}
    assert not bench.ports.may_run


def test_exchange_of_all_items() -> None:
    frame = FramedCodec().encode(exchange("WORD_VAR", 7, -1, -2))
    assert frame[:10] == bytes.fromhex("02 12 00 00 00 07 ff ff ff fe")


def test_a_session_over_a_serial_line(fieldrig_rig: RigMaker) -> None:
    rig = fieldrig_rig(
        {
            "time": "virtual",
            "buses": {"rs422": {"kind": "serial.virtual", "baud": 38_400}},
            "devices": {
                "pam": {
                    "kind": "pam_port_kinds:PortHost",
                    "program": HEADER + GROUP + RS422,
                    "links": {"line": "rs422"},
                }
            },
        }
    )
    link = rig.attach("plc").link("rs422")
    master = Rs422Master(PortBench(GROUP + RS422).variables, link.send, {"RWI_MachPressure": 3})
    link.on_receive(master.receive)
    master.begin(0)
    for at in range(100):
        rig.run_until(at * 10 * MS)
        master.poll(at * 10 * MS)
    assert master.is_running
    assert rig.get("pam", "state") == "running"
    assert rig.get("pam", "RWI_MachPressure.0") == 3
    rig.set("pam", "RRO_MachHeadLevel.1", 0.25)
    rig.run_until(S + 50 * MS)
    assert master.changes == [("RRO_MachHeadLevel", 1, 0.25)]


# The commands that lead to each phase, and those that belong to it, as in table 13-5 for the VME DualPort.
ASKED = [Code.ASK_DEF_IN] * 7
PHASES = {
    "before a session": ([], [Code.REQUEST, Code.ALIVE]),
    "before the inputs": ([Code.REQUEST], [Code.REQUEST, Code.ALIVE, Code.ASK_DEF_IN]),
    "among the inputs": ([Code.REQUEST, *ASKED[:3]], [Code.REQUEST, Code.ALIVE, Code.ASK_DEF_IN]),
    "outputs": (
        [Code.REQUEST, *ASKED, Code.DEF_OUT],
        [Code.REQUEST, Code.ALIVE, Code.DEF_OUT, Code.END_DEF_OUT],
    ),
    "initial values": (
        [Code.REQUEST, *ASKED, Code.END_DEF_OUT],
        [Code.REQUEST, Code.ALIVE, Code.INIT_IN, Code.XNG_FLAG, Code.END_INIT_IN],
    ),
    "ready": ([Code.REQUEST, *ASKED, Code.END_DEF_OUT, Code.END_INIT_IN], [Code.REQUEST, Code.ALIVE, Code.START]),
    "running": (
        [Code.REQUEST, *ASKED, Code.END_DEF_OUT, Code.END_INIT_IN, Code.START],
        [Code.REQUEST, Code.ALIVE, Code.XNG_FLAG],
    ),
}
VALUES = {Code.DEF_OUT: (crc_of("RFO_MachStopped"), 1), Code.XNG_FLAG: (1, 0, 1)}
COMMANDS = [
    Code.REQUEST, Code.ASK_DEF_IN, Code.DEF_OUT, Code.END_DEF_OUT, Code.INIT_IN, Code.END_INIT_IN, Code.START,
    Code.ALIVE, Code.XNG_FLAG,
]  # fmt: skip


@pytest.mark.manual("PAMS-107")
@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("command", COMMANDS, ids=lambda code: code.name)
def test_a_command_of_another_phase_is_e036(phase: str, command: Code) -> None:
    before, allowed = PHASES[phase]
    bench = PortBench(GROUP + RS422)
    bench.begin()
    for code in before:
        say(bench, code, *VALUES.get(code, ()))
    bench.kernel.reports.clear()
    answers = say(bench, command, *VALUES.get(command, ()))
    refused = Message(Code.ACK, (command, Result.REJECTED, 0, 0))
    assert (refused in answers) is (command not in allowed)
    assert ("07..E036" in bench.kernel.codes) is (command not in allowed)
