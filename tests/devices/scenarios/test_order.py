"""Actions at one instant have one order, whenever each of them was planned: a branch of a search plans some later."""

import pytest

from fieldrig import MS, Rig, from_dict
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.play import Stage
from fieldrig_devices.scenarios.property import Kind, Property

DATA = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "tank": {
            "kind": "plant.tank",
            "area_m2": 1,
            "height_m": 2,
            "outlet_area_m2": 0,
            "pump_flow_m3_per_s": 0.01,
            "initial_level_m": 0.5,
            "links": {"wires": "wires"},
        }
    },
}
PRESS = Act(0, "press", "tank/level", 1.0, 100 * MS)
LATER = Act(100 * MS, "set", "tank/level", 1.25, when="tank/level == 1", nth=1)
SET = Act(100 * MS, "set", "tank/level", 1.5)
RULE = Property("any", Kind.NEVER, expression_of("tank/level > 9"), None, None, None)


@pytest.mark.parametrize("planned_ns", [0, 20 * MS, 99 * MS])
def test_the_end_of_a_key_is_first_then_milestones_and_then_the_steps(planned_ns: int) -> None:
    with Rig(from_dict(DATA)) as rig, Stage(rig, (PRESS, LATER), [RULE]) as stage:
        stage.run_until(planned_ns)
        stage.add(SET)
        done = stage.finish(150 * MS).done
    assert [act.value for act in done if act.at_ns == 100 * MS] == [0.5, 1.25, 1.5]


@pytest.mark.parametrize("second_ns", [0, 20 * MS, 60 * MS, 99 * MS, 100 * MS, 130 * MS])
@pytest.mark.parametrize("hold_ns", [10 * MS, 40 * MS, 100 * MS])
def test_keys_that_are_pressed_at_a_time_are_up_in_the_end(second_ns: int, hold_ns: int) -> None:
    second = Act(second_ns, "press", "tank/level", 1.0, hold_ns)
    third = Act(second_ns + hold_ns // 2, "press", "tank/level", 1.75, hold_ns)
    with Rig(from_dict(DATA)) as rig, Stage(rig, (PRESS, second, third), [RULE]) as stage:
        stage.finish(400 * MS)
        assert rig.get("tank/level") == 0.5
