"""The extension for Visual Studio Code, as it is packed, with the real fieldrig; only the editor is a stand-in."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from fieldrig.real.live_rig import FIELDRIG
from fieldrig.testing import free_port
from fieldrig_devices.editor.editors import unpack
from fieldrig_devices.editor.package import extension_files, manifest

pytestmark = pytest.mark.real

PATIENCE_S = 300.0
"""The longest time for ten processes, one after the other, on a busy host."""
HERE = Path(__file__).parent
WITH_VSCODE = HERE.parent / "devices/editor/node/with_vscode.js"
RIG = """\
time: virtual
buses: {}
devices: {controller: {kind: max4, program: programs/count.st, autostart: true}}
"""
COUNT = "PROGRAM PLC_PRG\nVAR a : INT := 7; END_VAR\na := 7;\nEND_PROGRAM\n"
BAD = "FUNCTION Bad : BOOL VAR b:BOOL; END_VAR\nb := missing; END_FUNCTION\n"
TWICE = "FUNCTION Twice : INT\nVAR_INPUT x : INT; END_VAR\nTwice := 2 * x;\nEND_FUNCTION\n"
TESTS = "TEST 'right'\nASSERT_EQ(Twice(2), 4);\nEND_TEST\nTEST 'wrong'\nASSERT_EQ(Twice(2), 5, 'two');\nEND_TEST\n"
FILES = {
    "rig.yaml": RIG,
    "programs/count.st": COUNT,
    "bad.st": BAD,
    "twice.st": TWICE,
    "twice_test.st": TESTS,
}


def test_the_extension_shows_tests_problems_formats_and_values(tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed: apt-get install nodejs")
    folder = tmp_path / "work"
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    extension = unpack(tmp_path / "extensions", manifest(), extension_files())
    control = f"tcp/127.0.0.1:{free_port()}"
    done = subprocess.run(
        [node, "--require", WITH_VSCODE, HERE / "node/extension.js", extension, folder, control, *FIELDRIG],
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {
        "tests": [["passed", "right"], ["failed", "wrong", ["two: expected 5, got 4", 5]]],
        "covered": ["twice.st"],
        "wrong": [[2, 6, 0, "missing is not declared; expected a name from a declaration"]],
        "formatted": "FUNCTION Bad : BOOL\nVAR\n    b : BOOL;\nEND_VAR\n\nb := missing;\nEND_FUNCTION\n",
        "request": "launch",
        "device": "controller",
        "sources": "programs",
        "adapter": ["debug-adapter", "controller", "--control", control],
        "hover": "PLC_PRG.a = 7",
    }
