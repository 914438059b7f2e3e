"""Malformed questions to every process of a rig: each gets a negative answer, and all processes continue."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh
from running_rig import RunningRig

from fieldrig.control.messages import LONGEST_REFUSAL, Client, _message_of, key
from fieldrig.errors import ControlError

pytestmark = pytest.mark.system

KINDS = Path(__file__).with_name("lamp_kinds.py")
ROOT = Path(__file__).parents[2]
LAMP = """
time: {time}
buses:
  wires: {{kind: {wires}}}
  can0: {{kind: {can}}}
devices:
  lamp: {{kind: "lamp_kinds:Lamp", links: {{wires: wires}}}}
  switch: {{kind: "lamp_kinds:Switch", lamp: lamp, links: {{wires: wires}}}}
"""
HOSTILE: list[bytes] = [
    b"[" * 2000,
    b"[" * 500_000,
    b'{"a":' * 2000,
    b"[[1,2]]",
    b'[{"a":1}]',
    b"NaN",
    b"1" * 5000,
    b'"\\ud800"',
    b"\xff\xfe",
    b'{"keys":[[1]]}',
    b'{"keys":[{"a":1}]}',
    b'{"keys":{"a":1}}',
    b'{"values":{"on":[1]}}',
    b'{"values":{"on":{"a":1}}}',
    b'{"values":{"on":null}}',
    b'{"values":{"on":"\\u0000"}}',
    b'{"values":{"nothing":1}}',
    b'{"fault":{"what":["drop"]}}',
    b'{"fault":{"what":{"drop":1}}}',
    b'{"fault":{"what":"drop","count":1e308}}',
    b'{"fault":{"what":"drop","node":[[]]}}',
    b'{"fault":{"what":"drop","identifier":"&a [*a, *a]"}}',
    b'{"fault":{"what":"drop","start_ms":"' + b"[" * 5000 + b'"}}',
    b'{"fault":{},"number":"x"}',
    b'{"number":[1]}',
    b'{"number":99999}',
    b'{"name":["lamp"]}',
    b'{"name":"nobody"}',
    b'{"process":["lamp"],"pid":1}',
    b'{"process":"nobody","pid":1}',
    b'{"speed":1e308}',
    b'{"speed":-1}',
    b'{"speed":"fast"}',
    b'{"ns":18446744073709551615}',
    b'{"ns":-5}',
    b'{"ns":[5]}',
    b'{"command":"begin","id":"../*","owner":"o","signals":["lamp/on"],"rhythm":"cycle"}',
    b'{"command":"begin","id":"i","owner":"o","signals":["lamp/nothing"],"rhythm":"cycle"}',
    b'{"command":"begin","id":"i","owner":"o","signals":[["lamp/on"]],"rhythm":"cycle"}',
    b'{"command":"begin","id":"i","owner":"o","signals":["lamp/on"],"rhythm":1}',
    b'{"command":"again","id":"i","first":-9223372036854775808,"end":18446744073709551615}',
    b'{"command":"acknowledge","id":"i","number":1}',
    b'{"command":["end"],"id":"i"}',
]
PATHS = [
    *(f"rig/{verb}" for verb in ("restart", "join", "step", "run", "nonsense")),
    *(f"device/lamp/{verb}" for verb in ("get", "set", "add_fault", "clear_fault", "nonsense")),
    *(f"bus/{bus}/{verb}" for bus in ("can0", "wires") for verb in ("add_fault", "clear_fault", "nonsense")),
]


def raw_answers(client: Client, path: str, payload: bytes) -> Iterator[Any]:
    for reply in client.session.get(key("*", path), payload=zenoh.ZBytes(payload), timeout=30.0):
        try:
            yield _message_of(reply, path)
        except ControlError as refusal:
            yield refusal


@pytest.mark.parametrize(
    "rig", [LAMP.format(time="real", wires="wires.hub", can="can.hub"),
            LAMP.format(time="virtual", wires="wires.virtual", can="can.virtual")], ids=["real", "virtual"],
)  # fmt: skip
def test_a_hostile_question_gets_a_negative_answer_and_everybody_goes_on(rig: str) -> None:
    with RunningRig(rig, KINDS) as running:
        (running.until_ready if "real" in rig else running.until_there)()
        before = running.status()["processes"]
        process = running.status()["devices"]["lamp"]["process"]
        with Client(running.environment["FIELDRIG_CONTROL"]) as client:
            for path in (*PATHS, f"process/{process}/record"):
                for payload in HOSTILE:
                    answers = list(raw_answers(client, path, payload))
                    assert len(answers) == 1, (path, payload[:80], answers)
                    assert isinstance(answers[0], ControlError), (path, payload[:80], answers)
                    assert len(answers[0].what) <= LONGEST_REFUSAL
            for topic in ("ready/lamp", "trace/wires", "watch/wires", "event"):
                for payload in HOSTILE:
                    client.session.put(key(running.status()["rig"], topic), payload)
        assert running.tool("set", "switch/on=true").returncode == 0
        after = running.status()["processes"]
        assert {name: (entry["pid"], entry["restarts"]) for name, entry in after.items()} == {
            name: (entry["pid"], entry["restarts"]) for name, entry in before.items()
        }
        assert json.dumps(after)
