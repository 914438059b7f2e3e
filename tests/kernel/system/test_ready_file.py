"""The file for health checks: there and fresh while something is ready, and not otherwise."""

import asyncio
import os
import subprocess
from pathlib import Path

import pytest
from jumping_loop import run_jumping

from fieldrig.system.ready_file import PERIOD_S, ready_file

CHECK = 'test "$(find "$0" -name all -mmin -1)"'
"""The check of docker/service.yaml."""


def is_healthy(run: Path) -> bool:
    return (
        subprocess.run(["sh", "-c", CHECK, str(run / "ready")], stderr=subprocess.DEVNULL, check=False).returncode == 0
    )


def make_old(file: Path) -> None:
    os.utime(file, (0, 0))


def test_the_file_is_fresh_while_the_rig_is_ready(tmp_path: Path) -> None:
    async def rig() -> None:
        is_ready = False
        file = tmp_path / "ready" / "all"
        with ready_file(tmp_path, "all", lambda: is_ready):
            await asyncio.sleep(2 * PERIOD_S)
            assert not is_healthy(tmp_path)
            is_ready = True
            await asyncio.sleep(2 * PERIOD_S)
            assert is_healthy(tmp_path)
            make_old(file)  # as if this process had hung
            assert not is_healthy(tmp_path)
            await asyncio.sleep(2 * PERIOD_S)
            assert is_healthy(tmp_path)
            is_ready = False
            await asyncio.sleep(2 * PERIOD_S)
            assert not file.exists()
            is_ready = True
            await asyncio.sleep(2 * PERIOD_S)
        assert not file.exists()

    run_jumping(rig())


def test_a_file_that_a_killed_rig_has_left_is_removed(tmp_path: Path) -> None:
    async def rig() -> None:
        with ready_file(tmp_path, "all", lambda: False):
            await asyncio.sleep(PERIOD_S)
            assert not is_healthy(tmp_path)

    (tmp_path / "ready").mkdir()
    (tmp_path / "ready" / "all").touch()
    run_jumping(rig())


def test_a_disk_that_refuses_the_file_ends_nothing_and_is_told_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def rig() -> None:
        with ready_file(tmp_path, "all", lambda: True):
            await asyncio.sleep(10 * PERIOD_S)
            assert caplog.text.count("cannot be written, so health checks will fail") == 1
            (tmp_path / "ready").unlink()
            await asyncio.sleep(2 * PERIOD_S)
            assert is_healthy(tmp_path)

    (tmp_path / "ready").write_text("no folder")
    run_jumping(rig())
