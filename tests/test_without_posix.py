"""The work that needs no POSIX runs where there is none: in a process without all that Windows, or macOS, has not.

It is Linux all the same: paths, newlines, the console and the sockets of the other systems are not tried.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import portable_work
import pytest
from shipped import RIGS

pytestmark = [pytest.mark.system, pytest.mark.long, pytest.mark.timeout(300)]


def done(system: str, seen: str, folder: Path, *parts: str) -> dict[str, Any]:
    """Return the results of this work in a process without what the system has not."""
    command = [sys.executable, portable_work.__file__, system, seen, str(folder), *parts]
    result = subprocess.run(command, capture_output=True, encoding="utf-8", check=False, timeout=240)
    assert result.returncode == 0, result.stdout + result.stderr
    results: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return results


@pytest.fixture(scope="module")
def on_linux(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The output of masters on this system as it is."""
    results: dict[str, Any] = done("linux", "linux", tmp_path_factory.mktemp("linux"), "masters")["masters"]
    assert [code for code, _ in results.values()] == [0, 0, 0], results
    return results


def test_everything_but_real_time_works_without_posix(tmp_path: Path, on_linux: dict[str, Any]) -> None:
    results = done("win32", "win32", tmp_path)
    assert sorted(results["rigs"]) == RIGS
    codes = {line: code for line, (code, _) in results["commands"].items()}
    refused = {"check nothing.yaml", "search run searches/feeder.yaml"}
    assert {line for line, code in codes.items() if code != 0} == refused, results["commands"]
    code, text = results["commands"]["search run searches/feeder.yaml"]
    remedy = ["error: this system cannot branch a rig", "  branches need fork, which Linux has and Windows has not"]
    assert (code, text.splitlines()) == (3, remedy)
    assert results["masters"] == on_linux
    assert results["plugin"] == 0
    assert set(results["imported"]) == portable_work.POSIX_MODULES
    assert results["foreign"] == []
    _check_refusals(results["refusals"])
    traces = results["traces"]
    assert (traces["up"], traces["set"], traces["is_traced"]) == (0, {"run": True}, True)
    assert [traces[name] for name in portable_work.FORMATS] == [[0, True]] * len(portable_work.FORMATS)
    assert traces["codes"] == [0] * len(portable_work.OF_TRACES)
    assert "heartbeat io" in traces["show"][1]


def test_a_linux_without_these_calls_is_no_other_case(tmp_path: Path, on_linux: dict[str, Any]) -> None:
    results = done("win32", "linux", tmp_path, "masters", "refusals")
    assert results["masters"] == on_linux
    _check_refusals(results["refusals"])


def test_a_master_on_macos_does_the_same(tmp_path: Path, on_linux: dict[str, Any]) -> None:
    assert done("darwin", "darwin", tmp_path, "masters")["masters"] == on_linux


def _check_refusals(says: dict[str, Any]) -> None:
    """Each is one sentence with its reason, and what to do instead."""
    for code, text in (says["up"], says["only"]):
        assert (code, len(text.splitlines())) == (3, 2), text
        assert "error: this system cannot run a rig in real time" in text
        assert "time=virtual" in text
    assert says["pty"].startswith("modbus-rtu: this system has no pseudo-terminals\n  use TCP instead")
    assert says["branch"].startswith("this system cannot branch a rig\n  branches need fork")
