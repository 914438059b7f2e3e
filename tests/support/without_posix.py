"""Takes from this process what Windows, or macOS, has not, so that what needs it fails here as it would there.

Modules of POSIX cannot be imported by our packages, and calls, signals and families of sockets of the other system are
gone for everybody.  `sys.platform` is that of the other system for our packages alone: the standard library and foreign
packages have their own code for each system, and what they chose when they were imported goes on to work on this one.
Sockets and event loops keep to what they can do there: a socket pair goes over TCP, `select` takes sockets only, and
the usual event loop has no readers.
Left out: paths, newlines and the console of Windows.
"""

import asyncio
import builtins
import itertools
import os
import select
import selectors
import shutil
import signal
import socket
import stat
import sys
import time
import types
from collections.abc import Sequence
from typing import Any, Final, Literal

OURS: Final = ("fieldrig", "fieldrig_bus", "fieldrig_devices", "fieldrig_page")

LINUX_ONLY: Final = {
    os: (
        "eventfd", "eventfd_read", "eventfd_write", "memfd_create", "pidfd_open", "prlimit", "sched_getaffinity",
        "sched_getparam", "sched_getscheduler", "sched_setaffinity", "sched_setparam", "sched_setscheduler",
        "posix_fadvise", "posix_fallocate", "copy_file_range", "splice", "sendfile", "setresuid", "unshare", "waitid",
        "O_DIRECT", "EFD_NONBLOCK", "EFD_CLOEXEC", "MFD_CLOEXEC", "SCHED_FIFO", "SCHED_RR",
        "SCHED_RESET_ON_FORK",
    ),
    select: ("epoll", "EPOLLIN", "EPOLLOUT", "EPOLLHUP", "EPOLLERR"),
    selectors: ("EpollSelector",),
    signal: ("SIGPOLL", "SIGPWR", "SIGRTMIN", "SIGRTMAX", "SIGSTKFLT", "sigtimedwait", "sigwaitinfo"),
    socket: (
        "AF_CAN", "PF_CAN", "CAN_RAW", "CAN_BCM", "CAN_RAW_FILTER", "CAN_RAW_FD_FRAMES", "CAN_RAW_LOOPBACK",
        "CAN_RAW_RECV_OWN_MSGS", "SOL_CAN_BASE", "SOL_CAN_RAW", "AF_NETLINK", "AF_PACKET", "AF_VSOCK", "AF_ALG",
        "SO_BINDTODEVICE", "SO_MARK", "SO_INCOMING_CPU", "SOCK_NONBLOCK", "SOCK_CLOEXEC", "MSG_CONFIRM", "MSG_ERRQUEUE",
        "MSG_NOSIGNAL", "TCP_QUICKACK", "TCP_DEFER_ACCEPT", "TCP_LINGER2", "TCP_USER_TIMEOUT",
    ),
    time: ("CLOCK_BOOTTIME", "CLOCK_TAI", "pthread_getcpuclockid"),
}  # fmt: skip
"""The names that Linux has, and neither macOS nor Windows."""

POSIX_ONLY: Final = {
    os: (
        "fork", "forkpty", "openpty", "posix_openpt", "login_tty", "posix_spawn", "posix_spawnp", "setsid", "getsid",
        "setpgid", "getpgid", "getpgrp", "setpgrp", "killpg", "tcgetpgrp", "tcsetpgrp", "ttyname", "ctermid", "nice",
        "getpriority", "setpriority", "getloadavg", "getuid", "geteuid", "getgid", "getegid", "getgroups", "getresuid",
        "getresgid", "setuid", "seteuid", "setgid", "setegid", "setgroups", "setreuid", "setregid", "initgroups",
        "chown", "lchown", "fchown", "fchmod", "fchdir", "chroot", "mkfifo", "mknod", "makedev", "major", "minor",
        "sysconf", "sysconf_names", "confstr", "pathconf", "fpathconf", "uname", "pread", "pwrite", "preadv", "pwritev",
        "readv", "writev", "lockf", "fdatasync", "sync", "statvfs", "fstatvfs", "set_blocking", "get_blocking",
        "wait", "wait3", "wait4", "WNOHANG", "WIFEXITED", "WIFSIGNALED", "WTERMSIG", "WEXITSTATUS", "WUNTRACED",
        "register_at_fork", "sched_yield", "pipe2", "O_NONBLOCK", "O_CLOEXEC", "O_NOCTTY", "O_NOFOLLOW", "O_DIRECTORY",
        "O_SYNC", "O_DSYNC", "O_ASYNC", "O_ACCMODE", "EX_OK",
    ),
    select: ("poll", "POLLIN", "POLLOUT", "POLLHUP", "POLLERR", "POLLNVAL", "POLLPRI", "POLLRDHUP"),
    selectors: ("PollSelector",),
    signal: (
        "SIGALRM", "SIGBUS", "SIGCHLD", "SIGCLD", "SIGCONT", "SIGHUP", "SIGIO", "SIGIOT", "SIGKILL", "SIGPIPE",
        "SIGPROF", "SIGQUIT", "SIGSTOP", "SIGSYS", "SIGTRAP", "SIGTSTP", "SIGTTIN", "SIGTTOU", "SIGURG", "SIGUSR1",
        "SIGUSR2", "SIGVTALRM", "SIGWINCH", "SIGXCPU", "SIGXFSZ", "ITIMER_REAL", "ITIMER_VIRTUAL", "ITIMER_PROF",
        "alarm", "pause", "setitimer", "getitimer", "siginterrupt", "pthread_kill", "pthread_sigmask", "sigpending",
        "sigwait", "SIG_BLOCK", "SIG_UNBLOCK", "SIG_SETMASK",
    ),
    socket: ("AF_UNIX", "send_fds", "recv_fds", "SO_REUSEPORT", "SCM_RIGHTS", "SCM_CREDENTIALS", "CMSG_LEN"),
    time: ("clock_gettime", "clock_gettime_ns", "clock_settime", "clock_getres", "tzset", "CLOCK_MONOTONIC",
           "CLOCK_MONOTONIC_RAW", "CLOCK_REALTIME", "CLOCK_PROCESS_CPUTIME_ID", "CLOCK_THREAD_CPUTIME_ID"),
}  # fmt: skip
"""The names that macOS has as well, and Windows has not."""
POSIX_SOCKETS: Final = ("recvmsg", "recvmsg_into", "sendmsg")

FOREIGN: Final = {
    "win32": (
        "fcntl", "termios", "pty", "tty", "resource", "pwd", "grp", "spwd", "nis", "syslog", "readline", "curses",
        "crypt", "posix", "_posixshmem", "uvloop",
    ),
    "darwin": ("_epoll",),
}  # fmt: skip
"""Modules that the other system has not."""

System = Literal["win32", "darwin"]


def become(system: System, seen_platform: str | None = None) -> None:
    """Take away what the system has not.  It cannot be undone, so it belongs into a process of its own.

    `seen_platform` is `sys.platform` for our packages, usually that of the system.
    """
    loaded = sorted(name for name in sys.modules if name.partition(".")[0] in OURS)
    assert not loaded, f"loaded before: {loaded}"
    _delete(LINUX_ONLY)
    vars(shutil)["_USE_CP_SENDFILE"] = False  # a choice that it made when it was imported
    chosen: Any = selectors
    chosen.DefaultSelector = selectors.PollSelector if system == "darwin" else selectors.SelectSelector
    if system == "win32":
        _delete(POSIX_ONLY)
        _use_sockets_of_windows()
        _use_loop_of_windows()
    _import_as(seen_platform or system, FOREIGN[system])


def _delete(names: dict[Any, tuple[str, ...]]) -> None:
    for module, gone in names.items():
        for name in gone:
            vars(module).pop(name, None)


class _SysModule(types.ModuleType):
    """`sys` of another system: everything but its platform is that of this one."""

    def __init__(self, platform: str) -> None:
        super().__init__("sys")
        vars(self)["platform"] = platform

    def __getattr__(self, name: str) -> Any:
        return getattr(sys, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(sys, name, value)

    def __delattr__(self, name: str) -> None:
        delattr(sys, name)


def _import_as(platform: str, gone: Sequence[str]) -> None:
    real, seen = builtins.__import__, _SysModule(platform)

    def import_(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:
        if level == 0 and str((globals or {}).get("__name__", "")).partition(".")[0] in OURS:
            if name == "sys":
                return seen
            if name.partition(".")[0] in gone:
                raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return real(name, globals, locals, fromlist, level)

    builtins.__import__ = import_


def _use_sockets_of_windows() -> None:
    for name in POSIX_SOCKETS:
        if name in vars(socket.socket):
            delattr(socket.socket, name)
    windows: Any = socket
    windows.socketpair = _socketpair
    real_select: Any = select.select

    def select_(reads: Any, writes: Any, errors: Any, timeout: float | None = None) -> Any:
        lists = [list(each) for each in (reads, writes, errors)]
        if not any(lists):
            raise OSError(10022, "An invalid argument was supplied")
        for each in itertools.chain(*lists):
            number = each if isinstance(each, int) else each.fileno()
            if not stat.S_ISSOCK(os.fstat(number).st_mode):
                raise OSError(10038, "An operation was attempted on something that is not a socket")
        return real_select(*lists, timeout)

    windows = select
    windows.select = select_


def _socketpair(family: int = socket.AF_INET, type: int = socket.SOCK_STREAM, proto: int = 0) -> Any:
    """Do as the standard library does on Windows."""
    with socket.socket(family, type, proto) as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(1)
        near = socket.socket(family, type, proto)
        near.connect(listening.getsockname())
        return near, listening.accept()[0]


class _LoopOfWindows(asyncio.SelectorEventLoop):
    """The usual event loop of Windows, as far as it can do less than the one of POSIX."""


def _refuse(*_arguments: Any, **_options: Any) -> Any:
    raise NotImplementedError


REFUSED_BY_LOOP: Final = (
    "add_reader", "add_writer", "remove_reader", "remove_writer", "add_signal_handler", "remove_signal_handler",
    "create_unix_connection", "create_unix_server", "connect_read_pipe", "connect_write_pipe",
)  # fmt: skip


class _PolicyOfWindows(asyncio.DefaultEventLoopPolicy):
    _loop_factory = _LoopOfWindows


def _use_loop_of_windows() -> None:
    for name in ("open_unix_connection", "start_unix_server"):
        vars(asyncio).pop(name, None)
    for name in REFUSED_BY_LOOP:
        setattr(_LoopOfWindows, name, _refuse)
    windows: Any = asyncio
    windows.ProactorEventLoop = _LoopOfWindows
    windows.WindowsProactorEventLoopPolicy = _PolicyOfWindows
    asyncio.set_event_loop_policy(_PolicyOfWindows())
