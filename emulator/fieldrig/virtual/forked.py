"""A copy of this process that serves one pipe, and ends with it.

The copy has the memory of this process and none of its threads.  It lets go of everything else that they would share:
what it writes to a file or a socket of this process is lost, so that only this process writes there.
"""

import fcntl
import gc
import os
import select
import signal
import stat
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Final, NoReturn

assert sys.platform != "win32", "Windows has no fork"

OUTPUT: Final = 2
"""The highest descriptor that both processes keep: a branch prints where its rig prints."""

Serve = Callable[["Connection[Any, Any]"], None]


def fork(pipe: "Connection[Any, Any]", serve: Serve) -> int:
    """Start a copy that calls `serve(pipe)` and ends; return its process id.  The caller closes its own `pipe`."""
    for stream in (sys.stdout, sys.stderr):
        stream.flush()  # or the copy would write the same text again
    with warnings.catch_warnings():
        # Python 3.12 warns of threads; those that may be there are older than the rig and know nothing of it.
        warnings.simplefilter("ignore", DeprecationWarning)
        pid = os.fork()
    if pid == 0:
        _be_copy(pipe, serve)
    return pid


def _be_copy(pipe: "Connection[Any, Any]", serve: Serve) -> NoReturn:
    code = 1
    try:
        gc.freeze()  # a search for circles would write to every object: 32 MB of a conveyor, 1 MB with it
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to both, and this process ends with its pipe
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        _let_go(pipe.fileno())
        _end_with(pipe)
        serve(pipe)
        code = 0
    except BaseException:  # noqa: BLE001  this is the only place where it is seen
        traceback.print_exc()
    finally:
        # Not sys.exit: the frames above belong to the rig's process, and must not be unwound here.
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _let_go(pipe: int) -> None:
    """Put the null device in the place of every descriptor that both processes have."""
    kept = {pipe, *_numbers_of_output()}
    null = os.open(os.devnull, os.O_RDWR)
    for number in _descriptors():
        if number > OUTPUT and number not in kept and number != null:
            with suppress(OSError):  # the one by which they were listed
                _replace(number, null)
    os.close(null)


def _numbers_of_output() -> Iterator[int]:
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # a test's own stream has none
            yield stream.fileno()


def _descriptors() -> list[int]:
    for folder in ("/proc/self/fd", "/dev/fd"):
        with suppress(OSError):
            return [int(entry.name) for entry in Path(folder).iterdir()]
    return list(range(os.sysconf("SC_OPEN_MAX")))


def _replace(number: int, null: int) -> None:
    is_file = stat.S_ISREG(os.fstat(number).st_mode)
    if not is_file or fcntl.fcntl(number, fcntl.F_GETFL) & os.O_ACCMODE != os.O_RDONLY:
        os.dup2(number if number == null else null, number, inheritable=False)
        return
    own = os.open(f"/proc/self/fd/{number}", os.O_RDONLY)  # a place in the file of its own
    os.lseek(own, os.lseek(number, 0, os.SEEK_CUR), os.SEEK_SET)
    os.dup2(own, number, inheritable=False)
    os.close(own)


def _end_with(pipe: "Connection[Any, Any]") -> None:
    """End this process when the other end of the pipe is gone, also in the middle of its work."""
    end = pipe.fileno()
    signal.signal(signal.SIGIO, lambda _signal, _frame: end_if_gone(end))
    fcntl.fcntl(end, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(end, fcntl.F_SETFL, fcntl.fcntl(end, fcntl.F_GETFL) | os.O_ASYNC)
    end_if_gone(end)  # it may be gone already


def end_if_gone(end: int) -> None:
    """End this process if the other end of the pipe is gone.

    A process that waits for data gets no signal of it (`SOCK_WAKE_WAITD`), so it looks after each request: the other
    end may have sent it and ended before this process ran again.
    """
    gone = select.poll()  # one of its own: the signal may come while another one looks
    gone.register(end, 0)  # POLLHUP comes also before unread data
    if gone.poll(0):
        os._exit(1)
