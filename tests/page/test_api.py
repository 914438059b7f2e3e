"""The HTTP API as its OpenAPI document says: every operation is in it, and answers as described."""

import asyncio
import re
from pathlib import Path
from typing import Any

import pytest
from in_loop import in_loop
from jsonschema import Draft202012Validator
from page_api import described, filled
from page_bench import bearer, page_of

from fieldrig.clock import S

LAB = Path(__file__).parents[2] / "configs" / "lab.yaml"
pytestmark = pytest.mark.long


def validator(document: dict[str, Any], schema: dict[str, Any]) -> Draft202012Validator:
    return Draft202012Validator({**schema, "components": document["components"]})


@in_loop
async def test_every_operation_is_in_the_document_and_no_other() -> None:
    async with page_of(LAB) as page:
        paths = (await described(page))["paths"]
        said = {(method.upper(), path) for path, methods in paths.items() for method in methods}
        made = {(one.method, f"/{one.path.replace(':path}', '}')}") for one in page.site.operations}
        assert said == made
        for methods in paths.values():
            for operation in methods.values():
                assert re.match(r"[A-Z].*\.$", operation["summary"])
                assert all(parameter["description"] for parameter in operation["parameters"])


@in_loop
async def test_the_schemas_of_the_document_are_schemas() -> None:
    async with page_of(LAB) as page:
        document = await described(page)
        assert document["openapi"].startswith("3.1")
        for methods in document["paths"].values():
            for operation in methods.values():
                for part in (operation.get("requestBody", {}), *operation["responses"].values()):
                    for content in part.get("content", {}).values():
                        Draft202012Validator.check_schema(content["schema"])
                        list(validator(document, content["schema"]).iter_errors({}))  # every reference is there


@in_loop
async def test_what_is_read_is_as_described() -> None:
    async with page_of(LAB) as page:
        document = await described(page)
        read = 0
        for path, methods in document["paths"].items():
            if "get" not in methods:
                continue
            answer = await page.get(filled(path), "look")
            content = methods["get"]["responses"][str(answer.status)]["content"]
            if answer.headers["content-type"].startswith("application/json"):
                validator(document, content["application/json"]["schema"]).validate(answer.json)
            else:
                assert answer.headers["content-type"].partition(";")[0] in content
            read += answer.status == 200
        assert read >= 5


@in_loop
async def test_a_body_that_is_not_as_described_is_refused_as_described() -> None:
    async with page_of(LAB) as page:
        document = await described(page)
        for path, methods in document["paths"].items():
            for method, operation in methods.items():
                if "requestBody" not in operation:
                    continue
                answer = await page.call(method.upper(), filled(path), ["no", "such", "body"])
                assert answer.status == 422, path
                validator(document, document["components"]["schemas"]["Refusal"]).validate(answer.json)


@in_loop
async def test_unknown_parts_are_refused_with_the_nearest_name() -> None:
    async with page_of(LAB) as page:
        answer = await page.get("devices/tnak/points")
        assert answer.status == 404
        assert answer.json == {"what": "this rig has no device 'tnak'", "remedy": "did you mean tank?"}
        nothing = await page.get("nothing")
        assert (nothing.status, nothing.json["what"]) == (404, "there is no GET /api/v1/nothing")
        wrong = await page.request("DELETE", "/api/v1/status", headers=bearer("operate"))
        assert (wrong.status, wrong.json["what"]) == (405, "there is no DELETE /api/v1/status")


@in_loop
async def test_virtual_time_is_paused_stepped_and_let_run() -> None:
    async with page_of(LAB) as page:
        assert (await page.call("POST", "rig/step", {"for": "1.5 s"})).json == {
            "now_ns": 1_500_000_000,
            "is_paused": True,
        }
        refused = await page.call("POST", "rig/step", {"for": "soon"})
        assert refused.status == 422
        assert "'soon' is not a duration" in refused.json["what"]
        assert (await page.call("POST", "rig/run", {"speed": 2})).json["is_paused"] is False
        assert (await page.get("status")).json["speed"] == 2
        assert (await page.call("POST", "rig/run", {"speed": "max"})).status == 200
        assert (await page.call("POST", "rig/pause")).json["is_paused"] is True
        assert (await page.get("status")).json["speed"] is None
        assert (await page.call("POST", "rig/run", {"speed": -1})).status == 422
        assert (await page.call("POST", "restart/tank")).status == 200
        assert (await page.call("POST", "restart/nothing")).status == 409


@in_loop
@pytest.mark.parametrize(("ending", "body", "is_paused"), [("pause", None, True), ("run", {"speed": 1}, False)])
async def test_a_step_ends_where_it_is_when_someone_needs_the_rig(
    ending: str, body: dict[str, object] | None, *, is_paused: bool
) -> None:
    async with page_of(LAB) as page:
        step = asyncio.get_running_loop().create_task(page.call("POST", "rig/step", {"for": "100000000 s"}))
        while (status := (await page.get("status")).json)["now_ns"] == 0:
            assert not step.done()
            await asyncio.sleep(0)  # an answer within the process lets no other task run
        assert status["state"] == "ready"  # it moves
        ended = await page.call("POST", f"rig/{ending}", body)
        assert (ended.status, (await step).status) == (200, 200)
        status = (await page.get("status")).json
        assert status["state"] == ("paused" if is_paused else "ready")
        assert status["now_ns"] < 100_000_000 * S


@in_loop
async def test_a_rig_that_does_not_answer_is_said_to_be_away() -> None:
    async with page_of(LAB) as page:
        await page.control.close()
        assert (await page.get("status")).status == 503
        assert "fieldrig_up 0.0" in (await page.request("GET", "/metrics", headers=bearer("look"))).body.decode()
