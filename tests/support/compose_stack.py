"""One Compose project of ours for as long as a test needs it, on ports of this machine that are free."""

import json
import os
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import can
import canopen

from fieldrig.testing import free_port

FOLDER = Path(__file__).parents[2] / "docker"
OUTSIDE = (
    *("can0", "can1", "can2", "can3", "mb_tcp", "mb_rtu", "modbus", "labels", "labels_rtu"),
    *("user1", "user2", "jaw_line", "caller", "lan", "dualport", "pam_lan"),
)
"""The buses of the machine that a foreign master, caller or browser can be on."""
READY_LIMIT_S = 600
"""Time limit for twenty containers that start at once, on a host that may be busy."""
POLL_S = 0.5
ANSWER_LIMIT_S = 20.0


class Stack(NamedTuple):
    """A running Compose project."""

    file: str
    project: str
    ports: Mapping[str, int]
    """The ports by the distinguishing part of their variables, such as the name of the bus."""

    def compose(self, *arguments: str, over: Sequence[str] = ()) -> str:
        """Run a command of Compose, with further files `over` the project's own, and return its output."""
        environment = {
            **os.environ,
            **{f"FIELDRIG_{name.upper()}_PORT": str(port) for name, port in self.ports.items()},
        }
        files = [word for file in (self.file, *over) for word in ("-f", str(FOLDER / file))]
        command = [*compose_program(), "-p", self.project, *files, *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
        return done.stdout

    def containers(self) -> dict[str, Any]:
        """Return what Docker reports of each container, by the name of its service."""
        label = f"label=com.docker.compose.project={self.project}"
        ids = docker("ps", "-aq", "--filter", label).stdout.split()
        inspected = json.loads(docker("inspect", *ids).stdout)
        return {item["Config"]["Labels"]["com.docker.compose.service"]: item for item in inspected}

    def restarts(self) -> dict[str, int]:
        return {name: int(container["RestartCount"]) for name, container in self.containers().items()}

    def fieldrig(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """A tool inside the container of the control service."""
        return docker("exec", self.containers()["rig"]["Id"], "fieldrig", *arguments)

    def kill(self, service: str) -> None:
        """End all processes of a container from inside, which Docker takes for a failure of its own.

        The result of this command is left alone: the container may be gone before or after it ends.
        """
        docker("exec", self.containers()[service]["Id"], "sh", "-c", "kill -KILL -1")

    def until(self, is_so: Callable[[], bool], what: str) -> None:
        """Wait for a condition, and fail with the logs if it doesn't come in a generous time."""
        give_up = time.monotonic() + READY_LIMIT_S
        while not is_so():
            if time.monotonic() > give_up:
                raise AssertionError(f"{what}: it did not come\n{self.compose('logs', '--no-color', '--tail=20')}")
            time.sleep(POLL_S)

    def until_ready(self) -> None:
        """Wait until every part is ready."""
        self.until(lambda: self.fieldrig("status", "--ready", "all").returncode == 0, "all parts are ready")

    def until_healthy(self) -> None:
        """Wait until Docker's own check, that of the control service for all, has found that every part is ready.

        It costs next to nothing.  A tool runs in the container of the control service, and on a busy host it takes half
        of the time that this service has for its start.
        """
        self.until(lambda: self.health()["rig"] == "healthy", "the rig is healthy")

    def health(self) -> dict[str, str]:
        """Return the health of the containers that have a check."""
        states = {name: container["State"] for name, container in self.containers().items()}
        return {name: str(state["Health"]["Status"]) for name, state in states.items() if "Health" in state}

    def processes(self) -> list[str]:
        """Return the command lines of all processes in all containers."""
        ids = [container["Id"] for container in self.containers().values()]
        listed = [docker("top", container, "-eo", "pid,args").stdout.splitlines()[1:] for container in ids]
        return [line.strip().partition(" ")[2] for lines in listed for line in lines]

    @contextmanager
    def network(self, bus: str, port: str) -> Iterator[canopen.Network]:
        """A CANopen master on this machine, by socketcand."""
        with can.Bus(bus, "socketcand", host="127.0.0.1", port=self.ports[port]) as line:
            network = canopen.Network(line)
            network.connect()
            try:
                yield network
            finally:
                network.disconnect()


@contextmanager
def stack_of(
    file: str, ports: Sequence[str], beside: Callable[[], AbstractContextManager[object]] = nullcontext
) -> Iterator[Stack]:
    """Built, started `beside` something, and ready; all of it is gone in the end."""
    stack = Stack(file, f"fieldrig-test-{os.getpid()}-{file.split('.')[1]}", {name: free_port() for name in ports})
    try:
        stack.compose("build")
        with beside():
            stack.compose("up", "-d")
            stack.until_healthy()
            yield stack
    finally:
        stack.compose("down", "--volumes")


def node_of(network: canopen.Network, node_id: int, eds: Path) -> canopen.RemoteNode:
    """A node that is given time to answer."""
    node = network.add_node(node_id, str(eds))
    node.sdo.RESPONSE_TIMEOUT = ANSWER_LIMIT_S
    return node


def shut_in(container: Mapping[str, Any]) -> bool:
    """Check that a container can do nothing to this machine, and is reachable only from this machine."""
    host = container["HostConfig"]
    bindings = [binding["HostIp"] for bindings in host["PortBindings"].values() for binding in bindings]
    return bool(
        host["ReadonlyRootfs"]
        and host["CapDrop"] == ["ALL"]
        and "no-new-privileges:true" in host["SecurityOpt"]
        and container["Config"]["User"] not in ("", "0", "root")
        and set(bindings) <= {"127.0.0.1"}
    )


def compose_program() -> list[str]:
    """Compose 2 if Docker has it, else the old program."""
    has_plugin = subprocess.run(["docker", "compose", "version"], capture_output=True, check=False).returncode == 0
    return ["docker", "compose"] if has_plugin or shutil.which("docker-compose") is None else ["docker-compose"]


def docker(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["docker", *arguments], capture_output=True, text=True, check=False)
