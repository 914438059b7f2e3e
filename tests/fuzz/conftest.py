"""How many frames: a few thousand with the other tests, at least 100,000 by `make fuzz` (FIELDRIG_FUZZ_FRAMES)."""

import os

import pytest

FEW = 4_000


@pytest.fixture(scope="session")
def fuzz_frames() -> int:
    return int(os.environ.get("FIELDRIG_FUZZ_FRAMES", FEW))
