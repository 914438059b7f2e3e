"""`fieldrig record` in both times: the same rows, in files as their readers know them, and what is said about it."""

import csv
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from running_rig import RunningRig, until
from typer.testing import CliRunner
from vcd_reader import VCDVCD

from fieldrig.cli.app import app
from fieldrig.real.live_rig import FIELDRIG

pytestmark = pytest.mark.system

KINDS = Path(__file__).parents[1] / "kernel" / "recording" / "record_kinds.py"


def beats(time: str, wires: str) -> str:
    return f"""
{time}
buses:
  wires: {{kind: {wires}}}
devices:
  beat: {{kind: "record_kinds:Beat", cycle_ms: 20, links: {{wires: wires}}}}
  slow: {{kind: "record_kinds:Beat", cycle_ms: 100, links: {{wires: wires}}}}
"""


REAL = "time: real", "wires.hub"
VIRTUAL = "time: virtual\nspeed: max", "wires.virtual"


@pytest.fixture(scope="module")
def real() -> Iterator[RunningRig]:
    with RunningRig(beats(*REAL), KINDS) as rig:
        yield until_driven(rig)


@pytest.fixture(scope="module")
def fast() -> Iterator[RunningRig]:
    with RunningRig(beats(*VIRTUAL), KINDS) as rig:
        yield until_driven(rig)


def until_driven(rig: RunningRig) -> RunningRig:
    """Wait for the first cycle of the slow device, too: a wire has no value before it is driven."""
    rig.until_ready()
    until(lambda: "slow.count" in rig.ask("bus/wires/keys"))
    return rig


@pytest.fixture(params=["real", "fast"])
def rig(request: pytest.FixtureRequest) -> RunningRig:
    rig: RunningRig = request.getfixturevalue(request.param)
    return rig


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_each_cycle_is_a_row_in_both_times(rig: RunningRig) -> None:
    done = rig.tool("record", "beat/count", "beat/word", "wires/slow.*", "--for", "1s", "-o", "beat.csv")
    assert done.returncode == 0, done.stderr
    said = done.stderr.splitlines()
    assert said[0] == "recording 3 signals in beat.csv; Ctrl-C ends it"
    assert said[-1].startswith("beat.csv: ")
    assert said[-1].endswith("of 3 signals, nothing lost")
    rows = rows_of(rig.folder / "beat.csv")
    counts = [int(row["beat/count [1]"]) for row in rows if row["beat/count [1]"]]
    assert counts == list(range(counts[0], counts[0] + len(counts)))
    assert 48 <= len(counts) <= 51
    words = [row["beat/word"] for row in rows if row["beat/word"]]
    assert words == [("even", "odd")[count % 2] for count in counts]
    slow = [int(row["wires/slow.count [1]"]) for row in rows if row["wires/slow.count [1]"]]
    assert slow == list(range(slow[0], slow[0] + len(slow)))
    times = [float(row["time_s"]) for row in rows]
    assert times == sorted(times)
    assert 0 <= times[0] <= times[-1] <= 1


def test_ctrl_c_ends_a_recording_with_all_that_was_recorded(rig: RunningRig) -> None:
    file = rig.folder / "pulse.vcd"
    command = [*FIELDRIG, "record", "beat/pulse", "beat/count", "--changes", "-o", str(file)]
    recorder = subprocess.Popen(command, env=rig.environment, stderr=subprocess.PIPE, text=True)
    until(lambda: file.exists() and b"$enddefinitions" in file.read_bytes() and file.stat().st_size > 1_500)
    recorder.send_signal(signal.SIGINT)
    said = recorder.communicate(timeout=60)[1]
    assert recorder.returncode == 0, said
    assert said.splitlines()[-1].endswith("of 2 signals, nothing lost")
    read = VCDVCD(str(file))
    pulses = [(time, value) for time, value in read["beat.pulse"].tv if value != "x"][1:]
    assert [value for _, value in pulses[:4]] == ["1", "0", "1", "0"]
    assert pulses[0][0] == pulses[1][0], "the pulse is over at the instant at which it begins"


def test_a_recording_ends_with_a_recorder_that_is_killed(real: RunningRig) -> None:
    file = real.folder / "killed.csv"
    command = [*FIELDRIG, "record", "beat/count", "-o", str(file)]
    recorder = subprocess.Popen(command, env=real.environment, stderr=subprocess.DEVNULL)
    until(lambda: file.exists() and file.stat().st_size > 500)
    assert "its reader is gone" not in real.log("beat")
    recorder.kill()
    recorder.wait()
    until(lambda: "its reader is gone" in real.log("beat"))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["beat/cont", "-o", "x.csv"], "beat has no value 'cont'"),
        (["beet/count", "-o", "x.csv"], "lab has no device or bus 'beet'"),
        (["beat/x*", "-o", "x.csv"], "there is no signal 'beat/x*'"),
        (["beat", "-o", "x.csv"], "'beat' is not a signal"),
        (["beat/count", "-o", "x.cvs"], "no format of recordings ends in '.cvs'"),
        (["beat/count", "-o", "none/x.csv"], "none/x.csv cannot be written"),
        (["beat/count", "--every", "1ns", "-o", "x.csv"], "rhythm: expected"),
        (["beat/count", "--every", "1ms", "--changes", "-o", "x.csv"], "--every and --changes exclude each other"),
    ],
)
def test_a_wrong_wish_is_answered(fast: RunningRig, arguments: list[str], said: str, tmp_path: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        done = CliRunner().invoke(app, ["record", *arguments, "--control", fast.endpoint])
    assert done.exit_code != 0
    assert said in f"{done.output} {done.exception}".replace("\n", " ")


def test_a_full_disk_ends_a_recording_in_words(fast: RunningRig, tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("/dev/full")
    file = tmp_path / "x.csv"
    file.symlink_to("/dev/full")
    command = [*FIELDRIG, "record", "beat/count", "-o", str(file)]
    done = subprocess.run(command, env=fast.environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert f"error: {file} cannot be written: No space left on device" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_recording_ends_with_its_rig() -> None:
    with RunningRig(beats(*VIRTUAL), KINDS) as rig:
        rig.until_ready()
        file = rig.folder / "x.csv"
        command = [*FIELDRIG, "record", "beat/count", "-o", str(file)]
        recorder = subprocess.Popen(command, env=rig.environment, stderr=subprocess.PIPE, text=True)
        until(lambda: file.exists() and file.stat().st_size > 500)
        assert rig.tool("stop").returncode == 0
        said = recorder.communicate(timeout=60)[1]
        assert recorder.returncode == 0, said
        assert "-- the rig is being stopped" in said
        counts = [int(row["beat/count [1]"]) for row in rows_of(file)]
        assert counts == list(range(counts[0], counts[0] + len(counts)))
