"""Ctrl-C while the modules of a command are still imported."""

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
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130
