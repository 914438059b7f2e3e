"""How many inputs: some with the other tests, many by `make fuzz` (FIELDRIG_FUZZ_FRAMES, FIELDRIG_FUZZ_INPUTS).

A target that is slow says by the marker `share` which part of the others' inputs it takes.  The run tells at its end
how many inputs the targets that passed took.
"""

import math
import os
from typing import Any, Final

import pytest

from fieldrig.testing import free_port

FEW = 4_000
FEW_INPUTS = 5_000
INPUTS: Final = "fuzz inputs"


@pytest.fixture(scope="session")
def fuzz_frames() -> int:
    return int(os.environ.get("FIELDRIG_FUZZ_FRAMES", FEW))


@pytest.fixture
def inputs_a_target(request: pytest.FixtureRequest) -> int:
    """Return the share of all inputs for one decoder, listener, file or device."""
    all_inputs = int(os.environ.get("FIELDRIG_FUZZ_INPUTS", FEW_INPUTS))
    targets = [item for item in request.session.items if "inputs_a_target" in getattr(item, "fixturenames", ())]
    inputs = math.ceil(all_inputs * _share(request.node) / sum(map(_share, targets)))
    request.node.user_properties.append((INPUTS, inputs))
    return inputs


def _share(item: pytest.Item) -> float:
    marker = item.get_closest_marker("share")
    return 1.0 if marker is None else float(marker.args[0])


def pytest_terminal_summary(terminalreporter: Any) -> None:
    taken = [
        inputs
        for report in terminalreporter.getreports("passed")
        if report.when == "call"
        for name, inputs in report.user_properties
        if name == INPUTS
    ]
    if taken:
        terminalreporter.write_line(f"fuzz: {sum(taken):,} inputs at {len(taken)} targets, which all passed")


@pytest.fixture
def free_tcp() -> int:
    return free_port()
