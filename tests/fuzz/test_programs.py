"""Corrupted programs and questions about programs: a text compiles and runs, or has messages, and nothing else raises.

A program that compiles runs for some slices under a budget, as a task does; what it does wrong is a fault of its task.
"""

import json
import random
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from every_element import DOCUMENTS
from iec_program import IecBench, PlainHost
from spoiling import spoilt, spoilt_json

from fieldrig.clock import MS, VirtualClock
from fieldrig.outside.untrusted import read_json
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.solo import Solo
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.languages.debugging.framing import Framer, framed
from fieldrig_devices.languages.debugging.service import DebugService
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.max4.configuration.program_file import Container

pytestmark = pytest.mark.system

SEED = 2026
SLICE_NS = 250_000
SLICES = 20
VARIABLES = """
TYPE Form : STRUCT a : ARRAY[1..3] OF INT; b : BOOL; r : REAL; s : STRING(9); END_STRUCT END_TYPE
PROGRAM PLC_PRG
VAR i : INT; d : DINT; u : UDINT; w : WORD; r : REAL; b : BOOL; s, q : STRING; t : TIME; e : DT;
f : Form; g : ARRAY[0..4] OF Form; p : POINTER TO Form; n : POINTER TO DINT; o : TON; END_VAR
"""
BODIES = [
    "i := i + 1; d := d * 3 / i; w := SHL(w, i) XOR ROL(w, 3); u := u - 1; b := i > 5 AND NOT b;",
    "r := EXPT(r, 2) + SQRT(r) / 3.5; d := TRUNC(r); i := REAL_TO_INT(r * 1e30); t := REAL_TO_TIME(r); r := LN(-r);",
    "s := CONCAT(s, MID(q, i, d)); q := REPLACE(s, 'ab', i, 2); i := FIND(s, q); s := INSERT(DELETE(s, i, 3), q, 9);",
    "p := ADR(g[i]); p^.a[i] := 3; n := ADR(s) + i; n^ := n^ + 1; f := p^; g[2] := f; s := p^.s; p := p + SIZEOF(f);",
    "FOR i := 0 TO 32767 BY d DO d := d + 1; IF b THEN EXIT; END_IF END_FOR WHILE d > 0 DO d := d - i; END_WHILE",
    "CASE i OF 1, 3..5: o(IN := TRUE, PT := T#5s, Q => b); -32768: RETURN; ELSE i := STRING_TO_INT(s); END_CASE",
    "s := DT_TO_STRING(e); e := e + T#49d; t := STRING_TO_TIME(s); s := REAL_TO_STRING(r / 0.0); %QW5 := %IW3; ;",
]
CHART = b"""PROGRAM PLC_PRG VAR x : INT; END_VAR
INITIAL_STEP A: run(SD, T#5ms); END_STEP STEP B: run(R); ENTRY LD x
ADD ( 2
MUL 3 )
ST x
END_ENTRY END_STEP TRANSITION FROM A TO B := x > 3; END_TRANSITION TRANSITION FROM B TO (A) := TRUE; END_TRANSITION
ACTION run: x := x + 1; END_ACTION END_PROGRAM
"""
PROGRAMS = [CHART, *(f"{VARIABLES}{body}\nEND_PROGRAM".encode() for body in BODIES)]
FILES = [*PROGRAMS, *(document.encode() for document in DOCUMENTS)]
CONTAINERS = [Container((SourceFile("a.st", "PROGRAM a END_PROGRAM"), SourceFile("b.st", "")), "epas-4").encode()]


def _fuzz(
    name: str, make: Callable[[random.Random, list[bytes]], bytes], seeds: list[bytes], inputs: int,
    look: Callable[[bytes], Any],
) -> None:  # fmt: skip
    chance = random.Random(f"{SEED}/{name}")
    for _ in range(inputs):
        data = make(chance, seeds)
        try:
            look(data)
        except Exception as fault:
            raise AssertionError(f"{name}: {data!r}: {fault!r}") from fault


@pytest.mark.share(0.1)
def test_a_source_file_is_read_with_messages(inputs_a_target: int) -> None:
    def look(data: bytes) -> None:
        for dialect in (EPAS_4, EDITION_3):
            read_source("any.st", data.decode("latin-1"), dialect)

    _fuzz("source", spoilt, FILES, inputs_a_target, look)


@pytest.mark.share(0.02)
def test_a_program_runs_or_has_messages(inputs_a_target: int) -> None:
    def look(data: bytes) -> None:
        try:
            bench = IecBench(data.decode("latin-1"))
        except (CompileError, KeyError):  # another program than PLC_PRG
            return
        for _ in range(2):
            bench.thread.start()
            for _ in range(SLICES):
                if bench.thread.state is WorkState.READY:
                    bench.thread.run(SLICE_NS)
        bench.values()

    _fuzz("program", spoilt, PROGRAMS, inputs_a_target, look)


@pytest.mark.share(0.02)
def test_a_document_of_another_tool_compiles_or_has_messages(inputs_a_target: int) -> None:
    def look(data: bytes) -> None:
        with suppress(CompileError):
            compile_project([SourceFile("any.xml", data.decode("latin-1"))], PlainHost(), EDITION_3)

    _fuzz("document", spoilt, [document.encode() for document in DOCUMENTS], inputs_a_target, look)


def test_a_program_file_is_read_or_refused(inputs_a_target: int) -> None:
    def look(data: bytes) -> None:
        with suppress(ValueError):
            Container.decode(data)

    _fuzz("container", spoilt_json, CONTAINERS, inputs_a_target, look)


def test_the_framing_of_the_adapter_goes_on(inputs_a_target: int) -> None:
    seeds = [framed({"seq": 1, "type": "request", "command": "initialize"}), framed([1]), b"Content-Length: 5\r\n\r\n"]
    _fuzz("adapter", spoilt, seeds, inputs_a_target, lambda data: Framer().feed(data))


QUESTIONS: list[dict[str, Any]] = [
    {"command": "state"},
    {"command": "files"},
    {"command": "source", "file": "a.st", "first": 1},
    {"command": "breakpoints", "file": "a.st", "breakpoints": [{"line": 6, "condition": "PLC_PRG.i > 3"}]},
    {"command": "breakpoints", "file": "a.st", "breakpoints": []},
    {"command": "start"},
    {"command": "stop"},
    {"command": "pause"},
    {"command": "continue"},
    {"command": "reset", "kind": "cold"},
    {"command": "step", "kind": "over", "thread": 1},
    {"command": "stack", "thread": 1},
    {"command": "variables", "path": "PLC_PRG.g[1]"},
    {"command": "read", "names": ["PLC_PRG.i * 1.5 + PLC_PRG.g[2].r", "PLC_PRG.s", "PLC_PRG.w.3"]},
    {"command": "write", "values": {"PLC_PRG.i": 7, "PLC_PRG.s": "abc", "PLC_PRG.r": 1.5, "PLC_PRG.b": True}},
    {"command": "force", "values": {"PLC_PRG.d": 9, "PLC_PRG.p": 5}},
    {"command": "release", "names": ["PLC_PRG.d"]},
    {"command": "part", "file": "b.st", "text": "x", "is_first": True},
    {"command": "download", "online": True},
]


@pytest.mark.share(0.1)
def test_a_question_about_a_program_is_answered_or_refused(inputs_a_target: int) -> None:
    clock = VirtualClock()
    host = StandaloneHost(clock)
    text = f"{VARIABLES}i := i + 1;\nd := d + i;\nr := r + 0.5;\nEND_PROGRAM"
    solo = Solo(clock, host, compile_project([SourceFile("a.st", text)], host))
    service = DebugService(clock, solo)
    solo.start()
    count = 0

    def look(data: bytes) -> None:
        nonlocal count
        with suppress(ValueError):
            json.dumps(service.answer(read_json(data)))
        count += 1
        if count % 4 == 0:
            solo.run_until(clock.now_ns() + 20 * MS)

    _fuzz("question", spoilt_json, [json.dumps(question).encode() for question in QUESTIONS], inputs_a_target, look)
    assert service.answer({"command": "state"})["language"] == "IEC 61131-3"
