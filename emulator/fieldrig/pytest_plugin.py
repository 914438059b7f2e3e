"""Rigs as pytest fixtures: virtual time, one process, ready in milliseconds.

def test_level_rises(fieldrig_rig):
    rig = fieldrig_rig("rigs/tank.yaml")
    rig.set("drive", "run", True)
    rig.run_until(10 * S)
    assert rig.get("tank", "level") > 0.1
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fieldrig.rig import Rig

RigMaker = Callable[..., "Rig"]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addini("manual_rows", "TOML file with the rows that @pytest.mark.manual may name")
    about = "say which rows of the manuals the tests that ran have shown"
    parser.getgroup("fieldrig").addoption("--manual-rows", action="store_true", help=about)


def pytest_configure(config: pytest.Config) -> None:
    if file := config.getini("manual_rows"):
        from fieldrig.manual_rows import ManualRowsPlugin, RowList

        row_list = RowList.load(config.rootpath / file)
        config.pluginmanager.register(ManualRowsPlugin(row_list, report=config.getoption("manual_rows")))


@pytest.fixture
def fieldrig_rig() -> Iterator[RigMaker]:
    """Makes rigs of files (`str`, `Path`, with overrides such as "seed=3") or of dicts; closes them after the test."""
    # Imported here: every pytest run on the machine loads this file, few use it.
    from fieldrig.config import from_dict, load
    from fieldrig.rig import Rig

    with ExitStack() as rigs:

        def make(source: str | Path | dict[str, Any], *overrides: str) -> Rig:
            config = from_dict(source) if isinstance(source, dict) else load(Path(source), overrides)
            return rigs.enter_context(Rig(config))

        yield make
