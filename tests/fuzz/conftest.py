"""How many inputs: some with the other tests, many by `make fuzz` (FIELDRIG_FUZZ_FRAMES, FIELDRIG_FUZZ_INPUTS)."""

import os

import pytest
from addresses import free_port

FEW = 4_000
FEW_INPUTS = 5_000


@pytest.fixture(scope="session")
def fuzz_frames() -> int:
    return int(os.environ.get("FIELDRIG_FUZZ_FRAMES", FEW))


@pytest.fixture(scope="session")
def inputs_a_target(request: pytest.FixtureRequest) -> int:
    """Of all inputs, those of one decoder or listener."""
    return max(1, int(os.environ.get("FIELDRIG_FUZZ_INPUTS", FEW_INPUTS)) // _targets(request.session))


def _targets(session: pytest.Session) -> int:
    return sum("inputs_a_target" in getattr(item, "fixturenames", ()) for item in session.items)


@pytest.fixture
def free_tcp() -> int:
    return free_port()
