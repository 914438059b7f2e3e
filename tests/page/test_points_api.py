"""Points of devices by HTTP, in the words of `fieldrig get` and `fieldrig set`."""

from pathlib import Path

import pytest
from in_loop import in_loop
from page_bench import page_of

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"

pytestmark = pytest.mark.long


@in_loop
async def test_a_point_is_written_and_read_back() -> None:
    async with page_of(LAB) as page:
        written = await page.call("PUT", "devices/tank/points/level", {"value": 1.25})
        assert (written.status, written.json) == (200, {"value": 1.25})
        read = await page.get("devices/tank/points/level")
        assert read.json["value"] == 1.25
        assert read.json["unit"] == "m"


@in_loop
async def test_a_value_that_is_refused_is_answered_with_the_devices_own_words() -> None:
    async with page_of(LAB) as page:
        refused = await page.call("PUT", "devices/tank/points/level", {"value": 125})
        assert refused.status == 409
        assert refused.json["what"] == "level cannot be 125.0: expected a number from 0 to 2 m, got 125"
