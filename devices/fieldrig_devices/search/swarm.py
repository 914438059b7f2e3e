"""Dice over random subsets of the actions; the baseline for other strategies."""

from fieldrig.config.build import random_of
from fieldrig.points.values import counted
from fieldrig_devices.search.choices import one_of
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.strategy import Task, thrown


class Swarm:
    ahead = 64
    learns = False

    def __init__(self, task: Task) -> None:
        self._task, self._number, self._count = task, task.shard.number, 0

    def piece(self) -> Piece:
        task, length_ns = self._task, self._task.plan.scenario.length_ns
        dice = random_of(f"swarm/{self._number}", task.seed)
        acts = thrown(dice, task.bench.choices, 0, length_ns)
        self._number += task.shard.of
        return Piece(acts, 0, length_ns, world=one_of(dice, task.plan.worlds))

    def take(self, played: Run) -> bool:
        self._count += 1
        return False

    def told(self) -> str:
        return f"swarm: {counted(self._count, 'run')}"
