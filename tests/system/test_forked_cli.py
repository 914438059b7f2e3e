"""A command in a fork says what a command that was started says."""

import os
import subprocess
import sys
from pathlib import Path

import forked_cli
import pytest

from fieldrig.testing import free_port

pytestmark = pytest.mark.system

CONFIGS = Path(__file__).parents[2] / "configs"
PROGRAM = Path(sys.prefix) / "bin" / "fieldrig"


@pytest.mark.parametrize(
    ("line", "code", "script"),
    [
        ("check lab.yaml", 0, ""),
        ("nonsense", 2, ""),
        ("status --control tcp/127.0.0.1:{port}", 4, ""),
        ("debug max4 --control tcp/127.0.0.1:{port}", 4, "quit\n"),
        ("new", 0, "\n"),
    ],
)
def test_both_have_the_same_output_and_exit_code(line: str, code: int, script: str) -> None:
    words = line.format(port=free_port()).split()
    environment = {**os.environ, "COLUMNS": "90"}
    started = subprocess.run(
        [PROGRAM, *words], cwd=CONFIGS, env=environment, input=script, capture_output=True, text=True, check=False
    )
    forked = forked_cli.run(words, CONFIGS, environment, script)
    assert (forked.returncode, forked.stdout, forked.stderr) == (started.returncode, started.stdout, started.stderr)
    assert started.returncode == code


def test_a_command_that_takes_too_long_is_killed() -> None:
    with pytest.raises(subprocess.TimeoutExpired):
        forked_cli.run(["check", "machine.yaml"], CONFIGS, os.environ, limit_s=0.001)
