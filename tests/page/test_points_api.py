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


SENSOR = '''
from fieldrig import Device, Point


class Sensor(Device):
    """A sensor that is broken, as a Modbus master or a division may leave a float."""

    def points(self):
        return {"level": Point(lambda: float("nan")), "speed": Point(lambda: float("-inf")), "on": Point(lambda: True)}
'''


@in_loop
async def test_a_value_that_is_not_finite_hides_no_others(tmp_path: Path) -> None:
    """One of them made the whole device unreadable for every tool: NaN is no number of JSON, so it is a word there."""
    (tmp_path / "broken_sensor.py").write_text(SENSOR)
    rig = tmp_path / "rig.yaml"
    rig.write_text('{time: virtual, devices: {probe: {kind: "broken_sensor:Sensor"}}}')
    async with page_of(rig) as page:
        given = (await page.get("devices/probe/points")).json
        assert {point["key"]: point["value"] for point in given} == {
            "level": "nan",
            "speed": "-inf",
            "on": True,
        }
        assert (await page.get("devices/probe/points/level")).json["value"] == "nan"
