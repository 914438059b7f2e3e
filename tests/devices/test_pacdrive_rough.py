"""Rough hands on the whole ring: faults, healing, quits, enables and resets in any order lead to no dead end.

What a person would do in the end (heal, quit, enable) brings all axes under control again.
"""

from contextlib import suppress
from random import Random
from typing import Any

import pytest
from ring_lab import DRIVES, RingLab

from fieldrig.errors import ControlError

pytestmark = pytest.mark.long

OF_DRIVES = (
    "overtemperature", "overload", "dc_bus", "encoder_memory", "encoder_signal", "wrong_motor", "enable_lost",
    "supply_24v", "stuck_brake",
)  # fmt: skip
FAULTS: list[tuple[str, str, dict[str, Any]]] = [
    *(("ring", "break", {"after": place}) for place in ("master", *DRIVES)),
    *(("ring", "off", {"station": name}) for name in DRIVES),
    ("ring", "late", {"station": "film"}),
    ("ring", "distort", {"after": "jaw"}),
    ("ring", "distort", {"station": "jaw", "telegram": "mst", "count": 1}),
    ("ring", "distort", {"station": "infeed", "probability": 0.05}),
    *((name, what, {}) for name in DRIVES for what in OF_DRIVES),
    ("jaw_encoder", "silent", {}),
    ("jaw_encoder", "memory", {}),
    ("jaw_encoder", "checksum", {"of": "telegrams"}),
    ("max4", "power_off", {"days": 0}),
    ("max4", "power_off", {"days": 8}),
    ("max4", "overrun", {"us": 5_000}),
    ("max4", "memory_lost", {}),
]


class Hands:
    def __init__(self, lab: RingLab, random: Random) -> None:
        self.lab, self.random = lab, random
        self.given: list[tuple[str, int]] = []

    def act(self) -> None:
        random = self.random
        action = random.choices(
            (self.fault, self.heal, self.quit, self.enable, self.reset, self.press), (8, 4, 3, 3, 1, 1)
        )
        with suppress(ControlError):  # the controller has no power, or a fault was over by itself
            action[0]()
        self.lab.run(random.randrange(1, 1_800))

    def fault(self) -> None:
        where, what, more = self.random.choice(FAULTS)
        if self.random.random() < 0.4:
            more = {**more, "duration_ms": self.random.randrange(1, 1_500)}
        self.given.append((where, self.lab.fault(where, what, **more)))

    def heal(self) -> None:
        if self.given:
            self.lab.heal(*self.given.pop(self.random.randrange(len(self.given))))

    def quit(self) -> None:
        self.lab.do("quit")

    def enable(self) -> None:
        self.lab.set(f"{self.random.choice(DRIVES)}.ControllerEnable", self.random.random() < 0.7)

    def reset(self) -> None:
        self.lab.do("system reset")

    def press(self) -> None:
        """The emergency stop, or its release."""
        self.lab.rig.set("panel", "6200:01", self.random.randrange(2))


@pytest.mark.parametrize("seed", range(8))
def test_no_order_of_faults_is_a_dead_end(seed: int) -> None:
    random = Random(seed)
    with RingLab() as lab:
        lab.run(random.randrange(1, 6_000))  # not always is the ring up
        hands = Hands(lab, random)
        for _ in range(random.randrange(4, 16)):
            hands.act()
        while hands.given:
            with suppress(ControlError):
                hands.heal()
        lab.rig.set("panel", "6200:01", 1)
        lab.run(6_000)
        for _ in range(6):
            lab.do("quit").run(6_000)
        lab.enable().run(1_500)
        assert [lab.states(name) for name in DRIVES] == [(3, 0x21)] * 4
        assert (lab.diagnosis()[0], lab.get("ring.state")) == (0, "up")
