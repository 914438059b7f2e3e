"""Tests that are coroutines."""

import asyncio
from collections.abc import Callable, Coroutine
from functools import wraps
from typing import Any, ParamSpec

P = ParamSpec("P")
HANG_S = 300.0


def in_loop(test: Callable[P, Coroutine[Any, Any, None]]) -> Callable[P, None]:
    """Run a coroutine function as a test, in an event loop of its own.

    An exception in a callback, which the loop would only log, is the test's.  A test that hangs ends here: the alarm
    of pytest-timeout is an exception in any task that runs, which may take it for its own.
    """

    async def watched(*arguments: P.args, **options: P.kwargs) -> None:
        faults: list[BaseException] = []

        def note(_loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
            faults.append(context.get("exception") or RuntimeError(context["message"]))

        asyncio.get_running_loop().set_exception_handler(note)
        async with asyncio.timeout(HANG_S):
            await test(*arguments, **options)
        if faults:
            raise faults[0]

    @wraps(test)
    def run(*arguments: P.args, **options: P.kwargs) -> None:
        asyncio.run(watched(*arguments, **options))

    return run
