"""Rigs as pytest fixtures.

In virtual time, in the test's own process, ready in milliseconds:

    def test_level_rises(fieldrig_rig):
        rig = fieldrig_rig("rigs/tank.yaml")
        rig.set("drive/run", True)
        rig.run_until(10 * S)
        assert rig.get("tank/level") > 0.1

In real time, in processes of their own, for masters with a clock of their own:

    @pytest.fixture(scope="session")
    def modbus(fieldrig_up):
        port = free_port()
        fieldrig_up("rigs/tank-real.yaml", f"buses.mb_tcp.listen=127.0.0.1:{port}")
        return port
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fieldrig.real.live_rig import LiveRig
    from fieldrig.virtual.rig import Rig

RigMaker = Callable[..., "Rig"]
"""The fixture `fieldrig_rig`: makes a rig in virtual time of a file with overrides, or of a dict."""
LiveRigMaker = Callable[..., "LiveRig"]
"""The fixture `fieldrig_up`: starts a rig file with overrides in real time."""


@pytest.fixture
def fieldrig_rig() -> Iterator[RigMaker]:
    """Makes rigs of files (`str`, `Path`, with overrides such as "seed=3") or of dicts; closes them after the test."""
    # Imported here: every pytest run on the machine loads this file, few use it.
    from fieldrig.config.rig_file import from_dict, load
    from fieldrig.virtual.rig import Rig

    with ExitStack() as rigs:

        def make(source: str | Path | dict[str, Any], *overrides: str) -> Rig:
            config = from_dict(source) if isinstance(source, dict) else load(source, overrides)
            return rigs.enter_context(Rig(config))

        yield make


@pytest.fixture(scope="session")
def fieldrig_up() -> Iterator[LiveRigMaker]:
    """Starts rig files (`str`, `Path`, with overrides) in real time, and returns each when it is ready.

    Each has a control endpoint and a run folder of its own, so parallel workers don't meet; they end with the session.
    """
    from fieldrig.real.live_rig import LiveRig

    with ExitStack() as rigs:

        def start(file: str | Path, *overrides: str) -> LiveRig:
            return rigs.enter_context(LiveRig(file, *overrides))

        yield start
