"""The command line on a running rig, and its exit codes."""

import json
import re
from collections.abc import Iterator

import pytest
from lamp_rig import KINDS, lamp_rig
from running_rig import RunningRig, until
from typer.testing import CliRunner

from fieldrig.cli.app import app

pytestmark = pytest.mark.system

BLINKING = lamp_rig("period_ms: 20, ")


@pytest.fixture(scope="module")
def rig() -> Iterator[RunningRig]:
    with RunningRig(BLINKING, KINDS, "--trace", "all.jsonl") as rig:
        yield rig.until_ready()


def test_up_says_how_to_reach_each_part(rig: RunningRig) -> None:
    lines = rig.output().splitlines()
    assert lines[0] == f"lab: time: real, 3 processes, control at {rig.endpoint}"
    assert lines[2] == "devices: lamp, switch"
    assert lines[3].startswith("commands for each bus and device: ")
    assert lines[3].endswith(f"fieldrig help NAME --control {rig.endpoint}")
    assert "ready in" in lines[-1]


def test_status_for_people_and_for_scripts(rig: RunningRig) -> None:
    shown = rig.tool("status").stdout
    assert "lab: ready" in shown
    assert "wires.hub" in shown
    status = rig.json("status")
    assert status["version"] == 1
    assert status["state"] == "ready"
    assert status["processes"]["lamp"]["devices"] == ["lamp"]
    assert status["buses"]["wires"]["statistics"]["wires"] >= 2


@pytest.mark.parametrize(("name", "code"), [("lamp", 0), ("wires", 0), ("all", 0), ("rig", 0)])
def test_status_ready_is_an_exit_code(rig: RunningRig, name: str, code: int) -> None:
    assert rig.tool("status", "--ready", name).returncode == code


def test_status_ready_of_a_part_that_is_not_there_says_so(rig: RunningRig) -> None:
    done = rig.tool("status", "--ready", "lmap")
    assert done.returncode == 6
    assert done.stderr == "error: lab has no process, device or bus 'lmap'\n  did you mean lamp?\n"


def test_get_prints_what_it_could_get(rig: RunningRig) -> None:
    done = rig.tool("get", "lamp/colour", "bell/on", "switch/off", "lamp/times")
    assert done.returncode == 6
    assert [line.partition(" = ")[0] for line in done.stdout.splitlines()] == ["lamp/colour", "lamp/times"]
    assert (
        done.stderr
        == "error: lab has no device 'bell' (there are: lamp, switch); switch has no value 'off' (there are: on)\n"
    )
    done = rig.tool("get", "bell", "lamp/colour", "--json")
    assert (done.returncode, set(json.loads(done.stdout))) == (6, {"lamp/colour"})


def test_get_prints_what_it_could_get_when_a_process_is_dead() -> None:
    gone = '  extra: {kind: "lamp_kinds:Fragile", on_exit: ignore}\n'
    with RunningRig(BLINKING.replace("period_ms: 20, ", "") + gone, KINDS) as rig:
        rig.until_ready()
        rig.tool("set", "extra/hit=true")
        until(lambda: rig.status()["processes"]["extra"]["state"] == "gone")
        done = rig.tool("get", "lamp/colour", "extra/pid", "lamp/on")
        watching = rig.tool("watch", "lamp/colour", "extra/pid", "--for", "500ms")
        recording = rig.tool("record", "extra/pid", "-o", "nothing.csv", "--for", "1s")
    assert done.returncode == 6
    assert done.stdout == "lamp/colour = red\nlamp/on = false\n"
    assert "extra does not answer" in done.stderr
    assert "lamp/colour = red" in watching.stdout
    assert watching.stderr.count("-- extra does not answer: ") == 1
    assert recording.returncode == 6
    assert "extra does not answer: " in recording.stderr


def test_get_and_set(rig: RunningRig) -> None:
    assert set(rig.json("get", "lamp")) == {"lamp/on", "lamp/times", "lamp/colour"}
    assert rig.tool("set", "lamp/colour=green").stdout == "lamp/colour = green\n"
    assert rig.json("get", "lamp/colour") == {"lamp/colour": "green"}


@pytest.mark.parametrize("wrong", ["switch/onn=true", "lamp/tims=1"])
def test_set_writes_nothing_if_a_name_is_wrong(rig: RunningRig, wrong: str) -> None:
    """Once, what stood before the wrong name was written."""
    before = rig.json("get", "lamp/colour")
    other = "red" if before["lamp/colour"] == "green" else "green"
    assert "did you mean" in rig.tool("set", f"lamp/colour={other}", wrong).stderr
    assert rig.json("get", "lamp/colour") == before


@pytest.mark.parametrize(
    ("arguments", "code", "what"),
    [
        (("set", "lamp/colour=blue"), 6, "expected red or green"),
        (("set", "lamp/on=true"), 6, "on can only be read"),
        (("get", "lamp/weight"), 6, "lamp has no value 'weight'\n  there are: on, times, colour"),
        (("get", "lamp/tims"), 6, "did you mean times?"),
        (("get", "lmap"), 6, "lab has no device 'lmap'\n  did you mean lamp?"),
        (("get", "la*"), 6, "lab has no device 'la*'"),
        (("set", "lamp/color=green"), 6, "did you mean colour?"),
        (("set", "lmap/colour=green"), 6, "did you mean lamp?"),
        (("watch", "lamp/tim"), 6, "there is no value 'lamp/tim'\n  did you mean lamp/times?"),
        (("watch", "lmap/on"), 6, "did you mean lamp?"),
        (("watch", "wires", "wirse"), 6, "lab has no bus 'wirse'\n  did you mean wires?"),
        (("watch", "lamp"), 6, "`fieldrig watch lamp/*`"),
        (("trace", "record", "x.jsonl", "wirse", "-n", "1"), 6, "did you mean wires?"),
        (("trace", "record", "x.jsonl", "wirse", "--for", "1s"), 6, "did you mean wires?"),
        (("fault", "wirse"), 6, "did you mean wires?"),
        (("restart", "lmap"), 6, "did you mean lamp?"),
        (("status", "--ready", "lmap"), 6, "did you mean lamp?"),
        (("help", "lmap"), 6, "did you mean lamp?"),
        (("debug", "lmap"), 6, "did you mean lamp?"),
        (("debug-adapter", "lmap"), 6, "did you mean lamp?"),
        (("iec", "symbols", "x.xml", "--device", "lmap"), 6, "did you mean lamp?"),
        (("pam", "debug", "lmap"), 6, "did you mean lamp?"),
        (("up", "lab.yam"), 2, "did you mean lab.yaml?"),
        (("up", "lab.yaml", "--only", "lmap"), 2, "did you mean lamp?"),
        (("trace", "show", "al.jsonl"), 2, "did you mean all.jsonl?"),
        (("devices", "can.hubb"), 2, "did you mean can.hub?"),
        (("schema", "rg"), 2, "did you mean rig?"),
        (("new", "labb"), 2, "did you mean lab?"),
        (("wach", "wires"), 2, "Did you mean 'watch'?"),
        (("set", "lamp/colour"), 2, "such as tank/level=1.25"),
        (("step", "1ms"), 6, "this rig cannot step"),
        (("back", "1s"), 6, "this rig cannot go back"),
        (("step", "soon"), 2, "such as 10ms"),
        (("watch", "can0"), 6, "there are: wires"),
        (("watch", "can0", "lamp/on"), 2, "not both at once"),
        (("up", "lab.yaml", "--only", "bell"), 2, "there are: wires, lamp, switch"),
        (("up", "lab.yaml", "--trace", "x.doc"), 2, ".jsonl"),
    ],
)
def test_what_cannot_be_is_refused_with_what_would_be_right(
    rig: RunningRig, arguments: tuple[str, ...], code: int, what: str
) -> None:
    done = rig.tool(*arguments)
    assert (done.returncode, what in done.stderr) == (code, True), done.stderr
    assert "Traceback" not in done.stderr


def test_watch_shows_messages_and_changes(rig: RunningRig) -> None:
    lines = rig.tool("watch", "wires", "-n", "3").stdout.splitlines()
    assert len(lines) == 3
    assert all("switch" in line and "lamp.on = " in line for line in lines)
    message = json.loads(rig.tool("watch", "w*", "-n", "1", "--json").stdout)
    assert (message["bus"], message["sender"]) == ("wires", "switch")
    assert "lamp.on = " in rig.tool("watch", "wires", "-n", "1", "--rig", str(rig.file)).stdout
    assert "lamp/times = " in rig.tool("watch", "lamp/times", "-n", "2").stdout.splitlines()[1]
    assert rig.tool("watch", "lamp/colour", "--for", "300ms").returncode == 0


def test_a_script_knows_that_watch_has_not_seen_all_that_it_waits_for(rig: RunningRig) -> None:
    done = rig.tool("watch", "lamp/colour", "-n", "2", "--for", "500ms")
    assert (done.returncode, done.stdout.count("\n")) == (7, 1)
    assert done.stderr == "1 of 2 lines came within 500ms\n"
    assert rig.tool("watch", "lamp/colour", "-n", "1", "--for", "60s").returncode == 0


def test_traces_are_recorded_shown_and_converted(rig: RunningRig) -> None:
    done = rig.tool("trace", "record", "some.jsonl", "wires", "-n", "5")
    assert done.returncode == 0, done.stderr
    lines = rig.tool("trace", "show", "some.jsonl").stdout.splitlines()
    assert len(lines) >= 5
    assert "lamp.on = " in lines[0]
    assert rig.tool("trace", "convert", "some.jsonl", "same.jsonl").returncode == 0
    assert (rig.folder / "same.jsonl").read_bytes() == (rig.folder / "some.jsonl").read_bytes()
    waves = rig.tool("trace", "record", "some.vcd", "wires", "-n", "5")
    assert waves.stderr.endswith("some.vcd: 5 messages\n"), waves.stderr
    assert "$scope module lamp $end\n$var wire 1 ! on $end" in (rig.folder / "some.vcd").read_text()
    assert rig.tool("draw", "some.jsonl", "some.svg", "lamp.*").returncode == 0
    for arguments, what in (
        (("show", "some.jsonl", "wirse"), "did you mean wires?"),
        (("convert", "some.jsonl", "less.jsonl", "wirse"), "did you mean wires?"),
        (("convert", "some.jsonl", "less.vcd", "--wire", "lamp.n"), "did you mean lamp.on?"),
    ):
        wrong = rig.tool("trace", *arguments)
        assert (wrong.returncode, what in wrong.stderr) == (2, True), wrong.stderr
    assert not (rig.folder / "less.jsonl").exists()
    drawn = rig.tool("draw", "some.jsonl", "some.svg", "lamp.n")
    assert (drawn.returncode, "did you mean lamp.on?" in drawn.stderr) == (2, True), drawn.stderr
    unknown = rig.tool("trace", "show", rig.file.name)
    assert (unknown.returncode, ".jsonl" in unknown.stderr) == (2, True)


def test_a_trace_into_which_nothing_was_written_is_a_failure(rig: RunningRig) -> None:
    strange = rig.tool("trace", "record", "some.log", "wires", "-n", "5")  # candump holds CAN only
    assert (strange.returncode, strange.stderr.splitlines()[0]) == (
        2,
        "error: some.log: 0 messages; 5 are of kinds that this format cannot hold",
    )
    (rig.folder / "full.jsonl").symlink_to("/dev/full")
    full = rig.tool("trace", "record", "full.jsonl", "wires", "-n", "5")
    assert (full.returncode, full.stderr.splitlines()[-1]) == (
        2,
        "error: full.jsonl: 0 messages; 5 are missing: No space left on device",
    )


def test_up_records_from_the_first_message_on(rig: RunningRig) -> None:
    recorded: dict[str, str] = {}  # the first message of each

    def have_both_spoken() -> bool:
        for line in (rig.folder / "all.jsonl").read_text().splitlines():
            message = json.loads(line)
            recorded.setdefault(message["sender"], bytes.fromhex(message["data"]).decode())
        return len(recorded) == 2

    until(have_both_spoken)
    assert recorded == {"lamp": '["lamp.there",true,""]', "switch": '["lamp.on",true,""]'}


def test_no_rig_is_exit_code_4(rig: RunningRig) -> None:
    done = rig.tool("status", "--control", "tcp/127.0.0.1:1")
    assert done.returncode == 4
    assert "fieldrig up FILE" in done.stderr


def test_endpoint_that_was_typed_wins_over_the_variable(rig: RunningRig) -> None:
    typed = f"control=unixsock-stream/{rig.folder}/typed"  # the variable's endpoint is the running rig's, and taken
    done = rig.tool("up", "lab.yaml", "--set", typed)
    assert (done.returncode, f"another rig runs in {rig.run}" in done.stderr) == (3, True), done.stderr


def test_five_mistakes_are_said_at_once(rig: RunningRig) -> None:
    (rig.folder / "wrong.yaml").write_text(
        """
time: real
buses:
  wires: {kind: wires.hubb}
devices:
  lamp: {kind: "lamp_kinds:Lamp", colour: 5, links: {wires: wires}}
  switch: {kind: "lamp_kinds:Switch", links: {wire: wires}, on_exit: perhaps}
  bell: {kind: "lamp_kinds:Bell"}
  third: {kind: "lamp_kinds:Switch", lamp: lamp, links: {wire: wires, wires: wires}}
"""
    )
    found = json.loads(rig.tool("check", "wrong.yaml", "--json").stdout)
    assert {"file", "line", "column", "key", "what", "remedy"} == set(found[0])
    assert {item["line"] for item in found} <= set(range(1, 20))
    assert (rig.tool("check", "lab.yaml", "--json").stdout, rig.tool("check", "lab.yaml", "--json").returncode) == (
        "[]\n",
        0,
    )
    for command in ("check", "up"):
        done = rig.tool(command, "wrong.yaml")
        assert done.returncode == 2
        assert done.stderr.count("wrong.yaml:") >= 5
        for key in ("buses.wires.kind", "devices.lamp.colour", "devices.switch.on_exit", "devices.third.links.wire"):
            assert key in done.stderr


def test_check_takes_any_number_of_files(rig: RunningRig) -> None:
    (rig.folder / "good.yaml").write_text("time: virtual\nbuses: {wires: {kind: wires.virtual}}\n")
    (rig.folder / "bad.yaml").write_text("time: real\nsed: 1\n")
    done = rig.tool("check", "good.yaml", "bad.yaml", "lab.yaml")
    assert done.returncode == 2
    assert done.stdout.splitlines() == [
        "good.yaml has no mistakes: good, time: virtual, 1 bus, 0 devices",
        "lab.yaml has no mistakes: lab, time: real, 1 bus, 2 devices, 3 processes",
    ]
    assert done.stderr == "1 mistake\n  bad.yaml:2: sed: there is no such key\n      did you mean seed?\n"
    assert rig.tool("check", "good.yaml", "lab.yaml").returncode == 0
    listed = rig.tool("check", "good.yaml", "bad.yaml", "--json")
    assert (listed.returncode, [found["key"] for found in json.loads(listed.stdout)]) == (2, ["sed"])


def test_check_schema_and_devices_need_no_rig(rig: RunningRig) -> None:
    assert "has no mistakes" in rig.tool("check", "lab.yaml").stdout
    assert json.loads(rig.tool("schema").stdout)["title"]
    kinds = json.loads(rig.tool("devices", "--json").stdout)
    assert "wires.hub" in kinds["buses"]
    lamp = json.loads(rig.tool("devices", "lamp_kinds:Lamp", "--json").stdout)
    assert lamp["settings"]["colour"]["default"] == "red"
    assert lamp["links"]["wires"][0] == "wires.hub or wires.virtual or wires.zenoh"
    hub = rig.tool("devices", "can.hub").stdout
    assert re.search(r"^slcan\.path +string ", hub, re.MULTILINE)
    assert re.search(r"^eds +string +needed ", rig.tool("devices", "canopen.node").stdout, re.MULTILINE)
    assert rig.tool("devices", "lamp").returncode == 2


def test_every_command_has_help_with_an_example(rig: RunningRig) -> None:
    overview = rig.tool("--help").stdout
    assert "Exit codes:" in overview
    assert re.fullmatch(r"fieldrig \d+\.\d+\.\d+\n", rig.tool("--version").stdout)
    names = ("up", "status", "watch", "get", "set", "fault", "step", "run", "restart", "check", "devices", "schema")
    for command in names:
        assert f"fieldrig {command}" in CliRunner().invoke(app, [command, "--help"]).stdout
    for group in ("trace", "arp", "arp params", "eds", "nameplate"):
        said = CliRunner().invoke(app, [*group.split(), "--help"]).stdout
        assert said.count(f"    fieldrig {group} ") >= 1
        assert "--install-completion" not in said
