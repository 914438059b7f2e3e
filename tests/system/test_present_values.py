"""In real time too, what is read is the value at the instant of reading: a motor turns, and others see its wire."""

import pytest
from running_rig import AskedRig, until

pytestmark = pytest.mark.system

RIG = """
time: real
buses:
  wires: {kind: wires.hub}
devices:
  motor:
    kind: plant.servo
    links: {wires: wires}
    rated_torque_nm: 1.0
    motor_inertia_kg_m2: 0.001
    load_torque_nm: -0.001      # 1 rad/s2 from the start: published once, and never again
  card:
    kind: arp
    number: 1
    links: {wires: wires}
    signals: {encoder1: motor.encoder}
"""


def test_others_see_the_motor_where_it_is() -> None:
    with AskedRig(RIG, None) as rig:
        rig.until_ready()
        read = [0]

        def has_moved() -> bool:
            before, seen, after = (rig.get(point) for point in ("motor/encoder", "card/encoder1", "motor/encoder"))
            assert read[-1] <= before <= seen <= after, "each was read after the one before"
            read.append(after)
            return len(read) > 20 and after > 100

        until(has_moved)
        assert rig.get("motor/speed") > 0
