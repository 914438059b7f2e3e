"""The guard of the page: which requests are refused, and with which status."""

from collections.abc import Mapping

import pytest
from in_loop import in_loop
from page_bench import HOST, TANK, TOKENS, PageBench, bearer, page_of

from fieldrig_page.guard import Hosts

ORIGIN = f"http://{HOST}"
COOKIE = {role: {"cookie": f"fieldrig-8372={token}"} for role, token in TOKENS.items()}
LEVEL = "/api/v1/devices/tank/points/level"


async def write(page: PageBench, headers: Mapping[str, str]) -> int:
    """Return the status of a request that writes."""
    return (await page.request("PUT", LEVEL, b'{"value": 1}', headers)).status


@in_loop
async def test_a_token_in_the_address_becomes_a_cookie_and_leaves_the_address() -> None:
    async with page_of(TANK) as page:
        entry = await page.request("GET", f"/?token={TOKENS['look']}")
        assert (entry.status, entry.headers["location"]) == (303, "/")
        cookie, *attributes = entry.headers["set-cookie"].split("; ")
        assert cookie == f"fieldrig-8372={TOKENS['look']}"
        assert {"HttpOnly", "SameSite=lax"} <= set(attributes)
        assert entry.headers["referrer-policy"] == "no-referrer"
        assert (await page.request("GET", "/", headers={"cookie": cookie})).status == 200


@in_loop
@pytest.mark.parametrize(
    "path", ["/", "/static/app.js", "/static/vendor/preact.mjs", "/api/v1/status", "/metrics", "/x"]
)
async def test_nothing_is_shown_without_a_token(path: str) -> None:
    async with page_of(TANK) as page:
        for headers in ({}, {"cookie": "fieldrig-8372=wrong"}, {"authorization": "Bearer wrong"}, {"cookie": "é=é"}):
            assert (await page.request("GET", path, headers=headers)).status == 401
        assert (await page.request("GET", f"{path}?token=wrong")).status == 401


@in_loop
async def test_another_name_of_the_host_is_refused_as_a_page_elsewhere_may_lead_to_us() -> None:
    async with page_of(TANK) as page:
        for host in (
            "evil.example",
            "evil.example:8372",
            "127.0.0.1",
            "127.0.0.1:80",
            "127.0.0.1:8373",
            "",
            "a@127.0.0.1:8372",
        ):
            answer = await page.request("GET", "/", headers={**COOKIE["operate"], "host": host})
            assert answer.status == 421, host
        for host in ("127.0.0.1:8372", "localhost:8372", "[::1]:8372", "LOCALHOST:8372"):
            answer = await page.request("GET", "/", headers={**COOKIE["operate"], "host": host})
            assert answer.status == 200, host


@in_loop
async def test_another_site_may_neither_write_nor_read() -> None:
    async with page_of(TANK) as page:
        for origin in (
            "http://evil.example",
            "null",
            "http://127.0.0.1:8373",
            "http://localhost:8372",
            f"{ORIGIN}.evil",
        ):
            assert await write(page, {**COOKIE["operate"], "origin": origin}) == 403, origin
            assert (await page.request("GET", LEVEL, headers={**COOKIE["operate"], "origin": origin})).status == 403
        assert await write(page, COOKIE["operate"]) == 403  # a browser sends Origin with what is no GET
        assert await write(page, {**COOKIE["operate"], "origin": ORIGIN}) == 200


@in_loop
async def test_a_script_with_the_token_needs_no_origin() -> None:
    async with page_of(TANK) as page:
        assert await write(page, bearer("operate")) == 200
        assert await write(page, {**bearer("operate"), "origin": "http://evil.example"}) == 403


@in_loop
async def test_who_may_only_look_changes_nothing() -> None:
    async with page_of(TANK) as page:
        refused = await page.call("PUT", "devices/tank/points/level", {"value": 1}, "look")
        assert (refused.status, refused.json["what"]) == (403, "this address is for looking only")
        for operation in page.site.operations:
            if operation.method != "GET":
                answer = await page.call(operation.method, operation.path.replace("{", "").replace("}", ""), {}, "look")
                assert answer.status == 403, operation.path
        assert (await page.get("devices/tank/points/level", "look")).json["value"] != 1


@in_loop
async def test_sockets_are_refused_like_requests() -> None:
    async with page_of(TANK) as page:
        refused: list[tuple[str | None, dict[str, str]]] = [
            (None, {}),
            ("operate", {"origin": "http://evil.example"}),
            ("operate", {"origin": "null"}),
            ("operate", {"origin": ""}),
            ("operate", {"host": "evil.example:8372"}),
        ]
        for role, headers in refused:
            with pytest.raises(ConnectionError):
                await page.socket(None if role is None else "operate", headers)
        assert (await (await page.socket("look")).next())["role"] == "look"


@in_loop
async def test_the_policy_allows_only_our_own_scripts_and_the_import_map() -> None:
    async with page_of(TANK) as page:
        policy = (await page.request("GET", "/", headers=COOKIE["look"])).headers["content-security-policy"]
        scripts = next(part for part in policy.split("; ") if part.startswith("script-src "))
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert scripts.split()[1] == "'self'"
        assert [word[:8] for word in scripts.split()[2:]] == ["'sha256-"]


@in_loop
async def test_files_beside_the_pages_own_are_not_served() -> None:
    async with page_of(TANK) as page:
        for path in (
            "/static/../app.py",
            "/static/..%2fapp.py",
            "/static//etc/passwd",
            "/static/vendor/../../guard.py",
        ):
            assert (await page.request("GET", path, headers=COOKIE["operate"])).status == 404, path


@in_loop
async def test_a_body_that_is_too_long_or_malformed_is_refused() -> None:
    async with page_of(TANK) as page:
        for body in (
            b"{",
            b"\xff",
            b'{"value": NaN}',
            b"[" * 100,
            b'{"value": ' + b"1" * 300_000 + b"}",
            b"[]",
            b'"x"',
        ):
            answer = await page.request("PUT", LEVEL, body, bearer("operate"))
            assert answer.status == 422, body[:20]
            assert answer.json.keys() == {"what", "remedy"}


def test_beyond_loopback_addresses_are_names_of_ours_and_other_names_are_not() -> None:
    hosts = Hosts(("0.0.0.0", 8372), ["bench-pc:9000"])
    assert "192.168.3.7:8372" in hosts
    assert "bench-pc:9000" in hosts
    assert "BENCH-PC:9000" in hosts
    assert "bench-pc:8372" not in hosts
    assert "evil.example:8372" not in hosts
    assert "192.168.3.7:8373" not in hosts
    assert "192.168.3.7:8372" not in Hosts(("127.0.0.1", 8372))


def test_the_port_of_http_may_be_left_out_in_host() -> None:
    assert "127.0.0.1" in Hosts(("127.0.0.1", 80))
