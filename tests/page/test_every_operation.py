"""Every operation of the OpenAPI document: called without the right to, and with odd, huge and missing arguments."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

import pytest
from in_loop import in_loop
from page_api import described, filled, operations
from page_bench import HOST, TOKENS, Answer, bearer, page_of

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"
EVIL: Final = "http://evil.example"
COOKIE: Final = {"cookie": f"fieldrig-8372={TOKENS['operate']}", "origin": f"http://{HOST}"}
STRANGERS: Final[dict[str, tuple[int, dict[str, str]]]] = {
    "nobody": (401, {}),
    "a wrong token": (401, {"authorization": "Bearer wrong"}),
    "a token of another sort": (401, {"authorization": f"Basic {TOKENS['operate']}"}),
    "another host": (421, {**bearer("operate"), "host": "evil.example:8372"}),
    "another port": (421, {**COOKIE, "host": "127.0.0.1:8373"}),
    "another site with the cookie": (403, {**COOKIE, "origin": EVIL}),
    "another site with the token": (403, {**bearer("operate"), "origin": EVIL}),
}
"""Callers that may do nothing: the status of their answer, and the headers of their request."""
LOOKERS: Final = {
    "who may only look": bearer("look"),
    "a browser that may only look": {**COOKIE, "cookie": f"fieldrig-8372={TOKENS['look']}"},
    "a browser without its origin": {"cookie": COOKIE["cookie"]},
}
"""Callers that may read and not write, with the headers of their request."""
ODD_TEXTS: Final = (
    " ",
    "-1",
    "9" * 5_000,
    "x" * 20_000,
    "..",
    "%00",
    "\0",
    "é𝄞",
    "٣",
    "²",
    "a/b",
    "*",
    "$*",
    "NaN",
    "@x",
)
ODD_VALUES: Final[tuple[Any, ...]] = (
    *(None, False, -1, 0.5, 2**70, 1e308, "", "x" * 3_000, "\0", "\ud800", "NaN", "9" * 400 + " s", "-5 s", "٣"),
    *([], [[]], ["x"] * 2_000, {}, {"": {}}, {"x" * 5_000: [None]}),
)
QUICK: Final = {"timeout_s": 0.01}
"""A capture shall not be waited for."""

pytestmark = pytest.mark.long


@in_loop
async def test_a_stranger_may_call_no_operation() -> None:
    async with page_of(LAB) as page:
        before = await page.ask("device/tank/get")
        for method, path, _ in operations(await described(page)):
            for who, (status, headers) in STRANGERS.items():
                answer = await page.request(method, f"/api/v1/{filled(path)}", b"{}", headers)
                assert (answer.status, who, path) == (status, who, path)
                assert_is_refusal(answer)
        assert await page.ask("device/tank/get") == before
        assert (await page.get("faults")).json == []


@in_loop
async def test_who_may_only_look_may_call_no_operation_that_writes() -> None:
    async with page_of(LAB) as page:
        tried = 0
        for method, path, _ in operations(await described(page)):
            for who, headers in LOOKERS.items():
                answer = await page.request(method, f"/api/v1/{filled(path)}", b"{}", headers)
                assert (answer.status == 403, who, path) == (method != "GET", who, path)
                tried += method != "GET"
        assert tried > 30


@in_loop
async def test_no_argument_is_too_odd_for_an_answer_in_words() -> None:
    async with page_of(LAB) as page:
        document = await described(page)
        for method, path, operation in operations(document):
            for odd, body in requests(path, operation, document):
                answer = await page.request(method, f"/api/v1/{odd}", body, bearer("operate"))
                assert answer.status == 200 or 400 <= answer.status < 500, (method, odd[:80], body[:80], answer)
                if answer.status != 200:
                    assert_is_refusal(answer)


def requests(path: str, operation: dict[str, Any], document: dict[str, Any]) -> Iterator[tuple[str, bytes]]:
    """Yield paths and bodies in which one argument is missing, odd or huge."""
    good = json.dumps(QUICK if "captures" in path else {}).encode() if "requestBody" in operation else b""
    for parameter in operation["parameters"]:
        for text in ODD_TEXTS:
            if parameter["in"] == "path":
                yield filled(path, **{parameter["name"]: text}), good
            else:
                yield f"{filled(path)}?{parameter['name']}={quote(text)}", good
    if "requestBody" not in operation:
        return
    for whole in (b"", b"{", b"null", b"5", b"[]", b'"x"', b"[" * 5_000, b'{"value": 1e999}', b"x" * 300_000, b"\xff"):
        yield filled(path), whole
    for key in keys_of(operation, document):
        for value in ODD_VALUES:
            yield filled(path), json.dumps((QUICK if "captures" in path else {}) | {key: value}).encode()


def keys_of(operation: dict[str, Any], document: dict[str, Any]) -> list[str]:
    """Return the keys that a body may have, and one that it may not have."""
    schema = operation["requestBody"]["content"]["application/json"]["schema"]
    while "$ref" in schema:
        schema = document["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    return [*schema["properties"], "nothing"]


def assert_is_refusal(answer: Answer) -> None:
    """It says in words what is wrong."""
    assert answer.headers["content-type"] == "application/json"
    assert answer.json.keys() == {"what", "remedy"}
    assert len(answer.json["what"].split()) > 2
