"""A rig in virtual time under `fieldrig up`: paused, stepped, asked, and traced with the same bytes every time."""

import pytest
from lamp_rig import KINDS, lamp_rig
from running_rig import RunningRig, until

pytestmark = pytest.mark.system

BLINKING = lamp_rig("period_ms: 100, ", "time: virtual\nspeed: 2", "wires.virtual")


def test_time_is_paused_stepped_and_run_on() -> None:
    with RunningRig(BLINKING, KINDS) as rig:
        rig.until_ready()
        status = rig.status()
        process = status["processes"]["lab"]
        assert (process["state"], process["devices"], process["buses"]) == ("ready", ["lamp", "switch"], ["wires"])
        assert status["devices"]["lamp"]["links"] == {"wires": ["wires"]}
        assert status["overrides"] == [f"control={rig.endpoint}"]
        assert rig.tool("status", "--ready", "lab").returncode == 0
        start_ns = rig.json("step", "0s")["now_ns"]
        assert rig.status()["state"] == "paused"
        assert rig.json("step", "1s") == {"now_ns": start_ns + 1_000_000_000, "is_paused": True}
        times = rig.value("lamp/times")
        rig.json("step", "2s")
        assert rig.value("lamp/times") == times + 10
        assert rig.tool("set", "lamp/colour=green").returncode == 0
        assert rig.value("lamp/colour") == "green"
        rig.json("run", "max")
        until(lambda: rig.status()["now_ns"] > start_ns + 100_000_000_000)
        paused_ns = rig.json("pause")["now_ns"]
        assert rig.status()["now_ns"] == paused_ns
        rig.json("run", "1")
        until(lambda: rig.status()["now_ns"] > paused_ns)
        assert "lamp.on" in rig.tool("watch", "wires", "-n", "1").stdout
        assert rig.tool("restart", "lamp").returncode == 0
        assert rig.value("lamp/colour") == "red"  # as at power-on
        assert rig.tool("stop").returncode == 0
        assert rig.ended() == 0


def test_time_goes_back_with_values_faults_and_the_trace() -> None:
    with RunningRig(BLINKING, KINDS, "--trace", "x.jsonl") as rig:
        rig.until_ready()
        now_ns = rig.json("step", "1s")["now_ns"]
        times = rig.value("lamp/times")
        rig.json("step", "2s")
        assert rig.tool("set", "lamp/colour=green").returncode == 0
        rig.json("step", "500ms")
        assert rig.json("back", f"{now_ns}ns") == {"now_ns": now_ns, "is_paused": True}
        assert (rig.value("lamp/times"), rig.value("lamp/colour")) == (times, "red")
        assert rig.status()["now_ns"] == now_ns
        rig.json("step", "1s")
        assert rig.json("back", "300ms", "--by")["now_ns"] == now_ns + 700_000_000
        refused = rig.tool("back", "3600s")
        assert (refused.returncode, "the rig cannot go back to 3600 s" in refused.stderr) == (6, True)
        rig.json("run", "max")
        until(lambda: rig.status()["now_ns"] > now_ns + 10_000_000_000)
        assert rig.end() == 0
        shown = rig.tool("trace", "show", "x.jsonl").stdout.splitlines()
        assert f"back: to {now_ns / 1e9:g} s" in rig.output()
    instants = [float(line.split()[0]) for line in shown if "lamp.on" in line]
    assert instants == [round(0.1 * number, 6) for number in range(len(instants))]


def test_a_rig_with_processes_of_their_own_says_why_it_cannot_go_back() -> None:
    with RunningRig(BLINKING, KINDS, "--set", "processes=each") as rig:
        rig.until_ready()
        refused = rig.tool("back", "0s")
        assert (refused.returncode, "`processes: each` cannot go back" in refused.stderr) == (6, True)
        assert rig.tool("stop").returncode == 0
        assert rig.ended() == 0


def test_what_can_be_reached_is_said_before_it_is_ready() -> None:
    with RunningRig(BLINKING, KINDS) as rig:
        rig.until_ready()
        until(lambda: "ready in" in rig.output())
        lines = rig.output().splitlines()
    assert lines[0].startswith("lab: time: virtual")
    assert lines[-1].startswith("ready in")


def test_the_trace_starts_at_the_beginning_and_has_virtual_time() -> None:
    with RunningRig(BLINKING, KINDS, "--trace", "x.jsonl", "--set", "speed=max") as rig:
        rig.until_ready()
        until(lambda: rig.status()["now_ns"] > 10_000_000_000)
        assert rig.end() == 0
        shown = rig.tool("trace", "show", "x.jsonl").stdout.splitlines()
    assert [line.split() for line in shown[:3]] == [
        ["0.000000", "wires", "lamp", "lamp.there", "=", "True"],
        ["0.000000", "wires", "switch", "lamp.on", "=", "True"],
        ["0.100000", "wires", "switch", "lamp.on", "=", "False"],
    ]
    assert len(shown) > 100
