"""What a user does with vibrissa-client. The test checks the types of this program, and runs it."""

import asyncio
import json
import os
from inspect import iscoroutinefunction, isfunction
from urllib.request import urlopen

from vibrissa_client import ApiError, AsyncClient, Client, models


def every_operation_has_a_method() -> None:
    with urlopen(f"{os.environ['VIBRISSA_URL']}/openapi.json", timeout=30) as answer:
        paths = json.load(answer)["paths"].values()
    names = {one["operationId"] for path in paths for one in path.values() if "operationId" in one}
    assert len(names) > 100, names
    # A stream, which `events` reads.
    names.remove("follow_events")
    missing = {name for name in names if not isfunction(getattr(Client, name, None))}
    assert not missing, missing
    missing = {name for name in names if not iscoroutinefunction(getattr(AsyncClient, name, None))}
    assert not missing, missing


def lists(client: Client) -> models.Whisker:
    whiskers = list(client.all_whiskers(fleet="f", limit=1, sort="whisker_id"))
    assert [whisker["whisker"] for whisker in whiskers] == [0, 1], whiskers
    page = client.list_whiskers(limit=1)
    assert len(page["items"]) == 1 and page.get("next_cursor"), page
    lengths: list[float] = [whisker["length_mm"] for whisker in whiskers]
    assert all(40 < length_mm < 80 for length_mm in lengths), lengths
    return whiskers[1]


def curves(client: Client, whisker: models.Whisker) -> None:
    now = client.response_curve(whisker)
    assert now.name == "f/r/left/1" and len(now.ratio) == 12, now
    assert any(value is not None and value > 0 for value in now.per_mm["measured"]), now
    cut = client.what_if(whisker, length_mm=58)
    pairs = zip(cut.per_mm["whole"], cut.per_mm["cut to 58.0 mm"])
    assert any(
        before is not None and after is not None and abs(after / before - 1) > 0.05 for before, after in pairs
    ), cut


def actions(client: Client) -> None:
    body: models.ManualSetpoint = {"pressure_mpa": 0.08, "reason": "a test"}
    first = client.set_pressure("f", "r", "left", 1, body, idempotency_key="once")
    again = client.set_pressure("f", "r", "left", 1, body, idempotency_key="once")
    assert first["action_id"] == again["action_id"], (first, again)
    try:
        client.set_pressure("f", "r", "left", 1, {"pressure_mpa": 9.0})
    except ApiError as refused:
        assert refused.status == 422 and refused.problem is not None, refused
        assert "pressure_mpa" in str(refused), refused
    else:
        raise AssertionError("9 MPa was accepted")


def a_wrong_token_is_refused() -> None:
    with Client(token="not-the-token") as client:
        for attempt in (lambda: client.get_me(), lambda: next(client.events())):
            try:
                attempt()
            except ApiError as refused:
                assert refused.status == 401, refused
            else:
                raise AssertionError("a wrong token was accepted")


async def the_same_with_asyncio() -> None:
    async with AsyncClient() as client:
        whiskers = [whisker async for whisker in client.all_whiskers(limit=1)]
        curve = await client.response_curve(whiskers[0])
        assert len(whiskers) == 2 and len(curve.ratio) == 12
        try:
            await client.get_robot("f", "nobody")
        except ApiError as refused:
            assert refused.status == 404, refused
        else:
            raise AssertionError("an unknown robot was found")


def main() -> None:
    assert os.environ["VIBRISSA_URL"] and os.environ["VIBRISSA_TOKEN"]
    every_operation_has_a_method()
    with Client() as client:
        curves(client, lists(client))
        actions(client)
    a_wrong_token_is_refused()
    asyncio.run(the_same_with_asyncio())
    print("used")


if __name__ == "__main__":
    main()
