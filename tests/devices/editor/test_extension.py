"""The JavaScript of the extension, by its own tests in `node/`, with a stand-in for the editor."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from fieldrig_devices.editor import __file__ as package

HERE = Path(__file__).parent / "node"
EXTENSION = Path(package).parent / "extension"
PATIENCE_S = 120.0


@pytest.mark.system
def test_the_extension_does_what_its_own_tests_say() -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed: apt-get install nodejs")
    done = subprocess.run(
        [node, "--require", HERE / "with_vscode.js", "--test", HERE / "extension.test.js"],
        env={**os.environ, "EXTENSION": str(EXTENSION)},
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "# pass 0" not in done.stdout
