"""Bad days of the shipped rigs, by chance: no device raises, and what answered before answers again at the end.

`make fuzz` plays many in each rig; with the other tests there are a few, in the rigs that take little time.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Final

import pytest
from histories import Act, acts_of, answering, history, played

from fieldrig import Rig
from fieldrig.clock import S
from fieldrig.config.rig_file import load

pytestmark = [pytest.mark.lean, pytest.mark.long]

SEED: Final = 2026
INPUTS: Final = int(os.environ.get("FIELDRIG_FUZZ_INPUTS", "0"))
HISTORIES: Final = max(4, INPUTS // 20_000)
"""Histories of each rig: a history takes as long as thousands of other inputs."""
CONFIGS: Final = Path(__file__).parents[2] / "configs"
CHEAP: Final = ("drive", "energy-meter", "lab", "own-device", "smart-io")
ALL: Final = sorted(path.stem for path in CONFIGS.glob("*.yaml") if path.stem != "lab-vcan")
BOOT_NS: Final = 5 * S
TWICE: Final = 8
"""The number of histories of which one is played twice, and is the same to the last bit."""


@pytest.fixture(params=ALL if INPUTS else CHEAP)
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    with Rig(load(CONFIGS / f"{request.param}.yaml", ("time=virtual",))) as rig:
        rig.run_until(BOOT_NS)
        yield rig


def test_a_rig_comes_back_from_a_bad_day(rig: Rig, request: pytest.FixtureRequest) -> None:
    name = request.node.callspec.id
    with rig.branch() as thrown_away:
        possible = thrown_away.call(acts_of)
    with rig.branch() as quiet:
        expected = quiet.call(answering)
    for number in range(HISTORIES):
        dice = Random(f"{SEED}/histories/{name}/{number}")
        acts: list[Act] = history(rig, possible, dice)
        with rig.branch(number) as branch:
            outcome = branch.call(played, acts, expected)
        assert outcome.lost == (), acts
        if number % TWICE == 0:
            with rig.branch(number) as branch:
                assert branch.call(played, acts, expected) == outcome, acts
