"""The start of a command: what it imports, and Ctrl-C in the meantime."""

import gc
import subprocess
import sys
from types import ModuleType
from typing import Any

import pytest

from fieldrig.cli import main


class Interrupted(ModuleType):
    def __getattr__(self, _: str) -> Any:
        raise KeyboardInterrupt


def test_it_ends_without_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fieldrig.cli.outcome", Interrupted("fieldrig.cli.outcome"))
    monkeypatch.setattr("fieldrig.cli.SEARCHES", gc.get_threshold())  # this process runs other tests after it
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130


@pytest.mark.long
def test_a_command_that_reads_no_rig_file_imports_neither_pydantic_nor_yaml() -> None:
    code = "import sys, fieldrig.cli.app, fieldrig.control.endpoint; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"pydantic", "ruamel.yaml", "zenoh"}.intersection(done.stdout.split()) == {"zenoh"}
