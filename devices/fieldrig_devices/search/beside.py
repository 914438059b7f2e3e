"""A process beside this one that answers questions, as pickles on its standard input and output.

It has one thread or many, whatever its module needs, without a part in this one.  It ends with its input, so that a
process that dies leaves none behind.
"""

import pickle
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from typing import Any, Final

from fieldrig.errors import RigError

END_S: Final = 5.0

Answer = Callable[[Any], Any]


class Beside:
    """The end that asks."""

    def __init__(self, module: str, first: object) -> None:
        """Start a module that calls `serve`, and give it what it begins with.  What it raises is raised here."""
        command = [sys.executable, "-m", module]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            self.ask(first)
        except BaseException:
            self.close()
            raise

    def ask(self, question: object) -> Any:
        """Return the answer.  What the other end raises is raised here; RigError if the process is gone."""
        asked, answers = self._process.stdin, self._process.stdout
        assert asked is not None
        assert answers is not None
        try:
            pickle.dump(question, asked)
            asked.flush()
            is_good, answer = pickle.load(answers)
        except (OSError, EOFError) as cause:
            raise RigError("a process of the search has ended", "look at the messages above") from cause
        if not is_good:
            raise answer
        return answer

    def close(self) -> None:
        """End the process in order, or at once if it takes longer than some seconds."""
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def serve(begin: Callable[[Any], AbstractContextManager[Answer]]) -> None:
    """Answer until the questions end, with what `begin(first)` gives."""
    questions, answers = sys.stdin.buffer, sys.stdout.buffer
    sys.stdout = sys.stderr  # what a device prints is no answer

    def say(do: Callable[[], Any]) -> bool:
        outcome: tuple[bool, Any]
        try:
            outcome = True, do()
        except Exception as wrong:  # noqa: BLE001  it is raised where the question came from
            outcome = False, wrong
        pickle.dump(outcome, answers)
        answers.flush()
        return outcome[0]

    with suppress(EOFError):
        first, made = pickle.load(questions), list[AbstractContextManager[Answer]]()
        if not say(lambda: made.append(begin(first))):
            return
        with made[0] as answer:
            while True:
                question = pickle.load(questions)
                say(lambda question=question: answer(question))  # type: ignore[misc]
