"""Dice over random subsets of the actions; the baseline for other strategies."""

from fieldrig.config.build import random_of
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.strategy import Task, thrown


class Swarm:
    ahead = 64

    def __init__(self, task: Task) -> None:
        self._task, self._number, self._count = task, task.shard.number, 0

    def piece(self) -> Piece:
        plan, length_ns = self._task.plan, self._task.plan.scenario.length_ns
        acts = thrown(random_of(f"swarm/{self._number}", self._task.seed), plan, 0, length_ns)
        self._number += self._task.shard.of
        return Piece(acts, 0, length_ns)

    def take(self, played: Run) -> bool:
        self._count += 1
        return False

    def told(self) -> str:
        return f"swarm: {self._count} runs"
