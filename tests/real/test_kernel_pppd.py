"""pppd calls the wrapper of configs/teleservice.yaml, whose IP ends in the kernel: Linux at both ends of the call."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from network_namespace import network_namespace
from pppd import is_in_guest
from pppd_call import write_peer
from running_rig import AskedRig, until
from service_engineer import OFFLINE, PASSWORD, USER, reach_every_service

pytestmark = [
    pytest.mark.real,
    pytest.mark.ppp,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not is_in_guest(), reason="runs inside user-mode Linux: `python -m tests.driver ppp`"),
]

RIG = Path(__file__).parents[2] / "configs" / "teleservice.yaml"


@pytest.fixture
def rig() -> Iterator[AskedRig]:
    """The rig is in a network of its own, and pppd is outside: both ends would be addresses of one kernel otherwise."""
    with network_namespace() as outside, AskedRig(RIG, None, "--set", "buses.relay.ip=kernel") as rig:
        rig.until_ready()
        until(lambda: rig.get("max4/Com1UserState") == OFFLINE)
        with outside():
            yield rig


def test_pppd_calls_and_reaches_every_service(rig: AskedRig, tmp_path: Path) -> None:
    write_peer(rig.folder / "run/teleservice/modem", USER, PASSWORD)
    reach_every_service(rig, tmp_path)
    assert rig.control.ask("bus/relay/status")["packets"] > 40
