"""The HTTP API: what an operation of it is, how it is answered, and its OpenAPI document.

An operation describes itself once; its route, the check of its body and its part of `/api/v1/openapi.json` are made
from that.  A refusal is `{"what": ..., "remedy": ...}`, as on the command line.
"""

from collections.abc import Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import Any, Final, Literal, Protocol, runtime_checkable

from pydantic import StrictBool, StrictFloat, StrictInt, StrictStr, TypeAdapter, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Route

from fieldrig.control.messages import NoAnswerError
from fieldrig.errors import ControlError, RigError
from fieldrig.outside.untrusted import MalformedError, read_json
from fieldrig.text.nearest import closest
from fieldrig.text.strict_json import strict_json
from fieldrig_page.guard import LONGEST_BODY, DeniedError, refusal_json
from fieldrig_page.live import Role

GivenValue = StrictBool | StrictInt | StrictFloat | StrictStr
"""A value of a point in a body, in the type that JSON gives it."""
BASE: Final = "/api/v1"
OPENAPI: Final = "3.1.0"
REFUSAL: Final = {
    "type": "object",
    "required": ["what", "remedy"],
    "properties": {
        "what": {"type": "string", "description": "what is wrong"},
        "remedy": {"type": "string", "description": "what to do"},
    },
}
REFUSALS: Final = {
    "401": "the token is missing or wrong",
    "403": "another site asks, or the token is for looking only",
    "409": "the rig or a device refuses",
    "421": "the page has another name than `Host`",
    "422": "the request is not understood",
    "503": "the rig, or the process that is asked, does not answer",
}


@dataclass(frozen=True, slots=True)
class Call:
    """One call of an operation."""

    path: Mapping[str, str]
    """The parameters in its path."""
    query: Mapping[str, str]
    body: Any
    """The body, in the type that the operation takes; None if it takes none."""
    role: Role


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation of the API."""

    method: Literal["GET", "POST", "PUT", "DELETE"]
    path: str
    """The path below `/api/v1/`, such as `devices/{name}/points/{key:path}`."""
    about: str
    """Its summary, in one sentence."""
    do: Callable[[Call], Awaitable[Any]]
    """Returns what is answered as JSON, or a response of its own.

    DeniedError, ControlError, or ValueError for a request that is not understood.
    """
    takes: Any = None
    """Type of the body; None if it has none."""
    gives: Any = dict[str, Any]
    """Type of the answer, or its media type if it is a download."""
    parameters: Mapping[str, str] = field(default_factory=dict)
    """The meaning of each parameter of the path."""
    queries: Mapping[str, str] = field(default_factory=dict)
    """The meaning of each optional parameter of the query."""
    is_absent_if: str = ""
    """The reason of a 404, beside those of the parameters of the path."""

    def route(self) -> Route:
        async def answer(request: Request) -> Response:
            return await _answer(self, request)

        return Route(f"{BASE}/{self.path}", answer, methods=[self.method])


@runtime_checkable
class HasOperations(Protocol):
    """A topic whose own state has operations too."""

    def operations(self) -> Iterable[Operation]:
        """Return its operations."""


def document(operations: Iterable[Operation], rig: str) -> dict[str, Any]:
    """Return the OpenAPI document of the operations."""
    paths: dict[str, dict[str, Any]] = {}
    definitions: dict[str, Any] = {}
    for operation in operations:
        paths.setdefault(f"/{_plain(operation.path)}", {})[operation.method.lower()] = _described(
            operation, definitions
        )
    return {
        "openapi": OPENAPI,
        "info": {"title": f"fieldrig: {rig}", "version": version("fieldrig")},
        "servers": [{"url": BASE}],
        "security": [{"token": []}],
        "paths": paths,
        "components": {
            "schemas": {**definitions, "Refusal": REFUSAL},
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
    }


def known(name: str, parts: Mapping[str, Any], sort: str) -> str:
    """Return the name of a part of the rig.  DeniedError 404, with the closest names, if there is none of that name."""
    if name not in parts:
        raise DeniedError(404, f"this rig has no {sort} {name!r}", closest(name, list(parts)))
    return name


def refused(refusal: RigError, status: int) -> Response:
    return Response(refusal_json(refusal), status, media_type="application/json")


async def _answer(operation: Operation, request: Request) -> Response:
    try:
        body = await _body(operation, request)
        call = Call(request.path_params, request.query_params, body, request.scope["role"])
        given = await operation.do(call)
    except DeniedError as refusal:
        return refused(refusal, refusal.status)
    except NoAnswerError as cause:
        return refused(cause, 503)
    except ControlError as cause:
        return refused(cause, 409)
    except ValidationError as cause:
        return refused(RigError("the body is not as expected", _mistakes(cause)), 422)
    except ValueError as cause:
        return refused(RigError(f"not understood: {cause}", f"see {BASE}/openapi.json"), 422)
    except ClientDisconnect:
        return Response(status_code=400)  # to a client that has gone in the middle of its request
    if isinstance(given, Response):
        return given
    return Response(strict_json(given), media_type="application/json")


async def _body(operation: Operation, request: Request) -> Any:
    """Return the body in the operation's type.  ValueError for anything else."""
    data = bytearray()
    async for part in request.stream():
        data += part
        if len(data) > LONGEST_BODY:
            raise MalformedError(f"the body has more than {LONGEST_BODY} bytes")
    if operation.takes is None:
        return None
    return TypeAdapter(operation.takes).validate_python(read_json(data, LONGEST_BODY) if data else {})


def _mistakes(cause: ValidationError) -> str:
    errors = cause.errors(include_url=False, include_context=False, include_input=False)
    return "; ".join(f"{'/'.join(map(str, error['loc'])) or 'the body'}: {error['msg']}" for error in errors[:5])


def _plain(path: str) -> str:
    """Return a path without Starlette's converters: `{key:path}` is `{key}`."""
    return path.replace(":path}", "}")


def _described(operation: Operation, definitions: dict[str, Any]) -> dict[str, Any]:
    absent = operation.is_absent_if or ("there is no such part" if operation.parameters else "")
    description: dict[str, Any] = {
        "operationId": f"{operation.method.lower()}_{_identifier(operation.path)}",
        "summary": operation.about,
        "parameters": [
            *(_parameter(name, "path", about) for name, about in operation.parameters.items()),
            *(_parameter(name, "query", about) for name, about in operation.queries.items()),
        ],
        "responses": {
            "200": {"description": "done", "content": _content(operation.gives, definitions, "serialization")},
            **{
                status: {
                    "description": about,
                    "content": {"application/json": {"schema": {"$ref": "#/components/schemas/Refusal"}}},
                }
                for status, about in (REFUSALS | ({"404": absent} if absent else {})).items()
            },
        },
    }
    if operation.takes is not None:
        description["requestBody"] = {"content": _content(operation.takes, definitions, "validation")}
    return description


def _parameter(name: str, place: str, about: str) -> dict[str, Any]:
    required = {"required": True} if place == "path" else {}
    return {"name": name, "in": place, "description": about, "schema": {"type": "string"}, **required}


def _content(type_: Any, definitions: dict[str, Any], mode: Literal["validation", "serialization"]) -> dict[str, Any]:
    if isinstance(type_, str):
        return {type_: {"schema": {"type": "string", "format": "binary"}}}
    schema = TypeAdapter(type_).json_schema(mode=mode, ref_template="#/components/schemas/{model}")
    definitions |= schema.pop("$defs", {})
    return {"application/json": {"schema": schema}}


def _identifier(path: str) -> str:
    return "".join(character if character.isalnum() else "_" for character in _plain(path)).strip("_")
