"""A Docker daemon for the length of a test run, with the base image that our Dockerfile starts from.

Where a daemon answers, it is used as it is.  Where none does and we are root, one is started on a socket of its own
and stopped at the end; its images stay in ~/.cache/fieldrig, so that the next run is quick.  Where the base image
cannot be pulled, our daemon gets a stand-in of Debian packages under the same name; a foreign daemon never does.
"""

import fcntl
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

BASE = "python:3.11-slim-bookworm"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "fieldrig" / "docker"
STAND_IN_PACKAGES = "ca-certificates,python3,python3-venv,python3-pip"
CERTIFICATES = Path("/etc/ssl/certs/ca-certificates.crt")
PULL_LIMIT_S = 120
START_LIMIT_S = 60


def can_be_reached() -> bool:
    """True if everything that `reachable` needs is installed, including Compose."""
    has_compose = shutil.which("docker-compose") is not None or _docker({}, "compose", "version").returncode == 0
    can_start = os.geteuid() == 0 and all(shutil.which(name) for name in ("docker", "dockerd", "debootstrap"))
    return has_compose and (can_start or _answers({}))


@contextmanager
def reachable() -> Iterator[Mapping[str, str]]:
    """Environment for docker and Compose in which a daemon answers, as long as one can be had."""
    if _answers({}) or os.geteuid() != 0:
        yield {}
        return
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two daemons on one cache would destroy it
        with tempfile.TemporaryDirectory(prefix="fieldrig-docker-") as folder:
            yield from _own_daemon(Path(folder))


def _own_daemon(folder: Path) -> Iterator[Mapping[str, str]]:
    # The old builder: Debian's client has no other.
    environment = {
        "DOCKER_HOST": f"unix://{folder}/docker.sock",
        "DOCKER_BUILDKIT": "0",
        "COMPOSE_DOCKER_CLI_BUILD": "0",
        "FIELDRIG_BASE": BASE,  # by its tag: a stand-in has no digest
    }
    had_bridge = Path("/sys/class/net/docker0").exists()
    options = {"data-root": CACHE / "data", "exec-root": folder / "exec", "pidfile": folder / "dockerd.pid"}
    with (folder / "dockerd.log").open("w") as log:
        daemon = subprocess.Popen(
            ["dockerd", "-H", environment["DOCKER_HOST"], *(f"--{name}={value}" for name, value in options.items())],
            stdout=log,
            stderr=log,
            start_new_session=True,  # a Ctrl-C is for the tests, which then end the containers
        )
    try:
        _wait_for(daemon, environment, folder / "dockerd.log")
        _provide_base(environment)
        yield environment
    finally:
        _docker(
            environment, "image", "prune", "--force"
        )  # removes the remains of earlier builds; the cache would grow forever
        daemon.terminate()
        daemon.wait()
        if not had_bridge:
            subprocess.run(["ip", "link", "delete", "docker0"], capture_output=True, check=False)


def _answers(environment: Mapping[str, str]) -> bool:
    return _docker(environment, "version").returncode == 0


def _docker(environment: Mapping[str, str], *arguments: str, limit_s: float = 60) -> subprocess.CompletedProcess[bytes]:
    command = ["docker", *arguments]
    try:
        return subprocess.run(
            command, env={**os.environ, **environment}, capture_output=True, timeout=limit_s, check=False
        )
    except FileNotFoundError:
        return subprocess.CompletedProcess(command, 127, b"", b"")
    except subprocess.TimeoutExpired as late:
        return subprocess.CompletedProcess(command, 124, late.stdout or b"", late.stderr or b"")


def _wait_for(daemon: subprocess.Popen[bytes], environment: Mapping[str, str], log: Path) -> None:
    give_up = time.monotonic() + START_LIMIT_S
    while not _answers(environment):
        if daemon.poll() is not None or time.monotonic() > give_up:
            raise RuntimeError(f"dockerd doesn't start:\n{log.read_text(encoding='utf-8')[-2000:]}")
        time.sleep(0.1)


def _provide_base(environment: Mapping[str, str]) -> None:
    if _docker(environment, "image", "inspect", BASE).returncode == 0:
        return
    if _docker(environment, "pull", BASE, limit_s=PULL_LIMIT_S).returncode == 0:
        return
    sys.stdout.write(f"docker: {BASE} cannot be pulled; a stand-in is made of Debian packages (a minute)\n")
    sys.stdout.flush()
    with tempfile.TemporaryDirectory(prefix="fieldrig-base-") as folder:
        root = Path(folder)
        _debian_with_python(root)
        with subprocess.Popen(["tar", "-C", root, "-c", "."], stdout=subprocess.PIPE) as tar:
            command = ["docker", "import", "-", BASE]
            subprocess.run(
                command, stdin=tar.stdout, env={**os.environ, **environment}, check=True, capture_output=True
            )


def _debian_with_python(root: Path) -> None:
    """Debian 12 where `python` and pip work as in the real image, and which trusts whom this machine trusts."""
    command = ["debootstrap", "--variant=minbase", f"--include={STAND_IN_PACKAGES}", "bookworm", str(root)]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise RuntimeError(f"debootstrap failed:\n{made.stdout[-2000:]}{made.stderr[-2000:]}")
    shutil.copy(CERTIFICATES, root / CERTIFICATES.relative_to("/"))
    (root / "etc" / "pip.conf").write_text(f"[global]\ncert = {CERTIFICATES}\n")
    (root / "usr" / "lib" / "python3.11" / "EXTERNALLY-MANAGED").unlink()
    for name in ("python", "python3"):
        (root / "usr" / "local" / "bin" / name).symlink_to("/usr/bin/python3")
    shutil.rmtree(root / "var" / "cache" / "apt")
