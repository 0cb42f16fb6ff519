"""The page and its socket, as any client sees them."""

import json
import shlex
import signal
import socket
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec.structs import replace
from PIL import Image
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

import clrt
from clrt.commands.cli import main
from clrt.errors import RequestError
from clrt.viewer.server import MESSAGE, View
from clrt.viewer.session import Session
from clrt.viewer.subject import Subject, of

NONSENSE = [
    "nonsense",
    '{"do": "fly"}',
    b"\xff\xfe",
    '{"do": "reset"}' + " " * MESSAGE,
    "[" * MESSAGE,
]


class Served(NamedTuple):
    """A view, and the connections to it that are open."""

    address: str
    clients: ExitStack

    @property
    def socket(self) -> str:
        return self.address.replace("http:", "ws:").replace("/?", "/ws?")


@pytest.fixture(scope="module")
def renderer() -> Iterator[clrt.Renderer]:
    with clrt.Renderer() as found:
        yield found


@pytest.fixture(params=["four-spheres"])
def served(request: pytest.FixtureRequest, renderer: clrt.Renderer) -> Iterator[Served]:
    given = request.param
    subject = given if isinstance(given, Subject) else of(given)
    view = View(renderer, lambda: Session(subject), "a <title>")
    with view.listen("127.0.0.1", 0) as listening:
        thread = threading.Thread(target=listening.serve_forever)
        thread.start()
        with ExitStack() as clients:
            yield Served(view.address(listening), clients)
    thread.join(10)
    assert not thread.is_alive()


class Client:
    """A page that has no screen."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection

    def say(self, do: str, **more: Any) -> None:
        self.connection.send(json.dumps({"do": do, **more}))

    def hear(self) -> tuple[dict[str, Any], bytes]:
        data = self.connection.recv(timeout=60)
        assert isinstance(data, bytes)
        header, _, file = data.partition(b"\n")
        told = json.loads(header)
        if told.get("preview"):  # it comes before the first picture, or does not
            return self.hear()
        if "number" in told:
            self.say("shown", number=told["number"])
        return told, file

    def final(self, changes: int = 1) -> tuple[dict[str, Any], bytes]:
        """The last picture, after so many changes."""
        while True:
            header, file = self.hear()
            if header.get("final") and header["changes"] == changes:
                return header, file


def opened(served: Served) -> Client:
    client = Client(served.clients.enter_context(connect(served.socket, max_size=None)))
    assert client.hear()[0]["about"]["spheres"] > 0
    client.say("resize", width=64, height=36)
    return client


def status(address: str, **headers: str) -> int:
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def test_the_page(served: Served) -> None:
    with urllib.request.urlopen(served.address, timeout=10) as answer:
        text, headers = answer.read().decode(), answer.headers
    assert "<title>a &lt;title&gt;</title>" in text
    assert "http:" not in text
    assert "https:" not in text.replace('"https:"', "")  # from nowhere else
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert headers["Referrer-Policy"] == "no-referrer"
    assert served.address.partition("=")[2] not in text


def test_the_token_is_asked_for(served: Served) -> None:
    base, _, token = served.address.partition("?token=")
    assert len(token) >= 20
    wrong = "".join(reversed(token))
    for query in ("", "?", "?token=", f"?token={wrong}", f"?token={token}&token=x", "?token=%ff"):
        for path in ("", "ws", "favicon.ico"):
            assert status(f"{base}{path}{query}") == 403
        with pytest.raises(InvalidStatus, match="403"):
            opened(Served(f"{base}{query}", served.clients))
    assert status(f"{base}?token={token}") == 200
    assert status(f"{base}view.js?token={token}") == 404


def test_pages_from_elsewhere_cannot_connect(served: Served) -> None:
    host = served.address.split("/")[2]
    for origin in (
        "http://example.org",
        "http://127.0.0.1:1",
        f"http://{host}.example.org",
        "null",
    ):
        with pytest.raises(InvalidStatus, match="403"):
            served.clients.enter_context(connect(served.socket, origin=Origin(origin)))
        assert status(served.address, Origin=origin) == 403
    served.clients.enter_context(connect(served.socket, origin=Origin(f"http://{host}")))
    # Through `ssh -L 9000:...` the page is from another port, and so is what it asks.
    assert status(served.address, Origin="http://localhost:9000", Host="localhost:9000") == 200


def test_the_last_picture_is_that_of_its_command(
    served: Served, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    client = opened(served)
    header, file = client.hear()
    assert (header["moves"], file[:2]) == (True, b"\xff\xd8")  # JPEG
    client.say("turn", x=5, y=-7.25)
    client.say("project", projection="orthographic")
    client.say("zoom", factor=1.3, x=10, y=20)
    client.say("sample", samples=4)
    header, file = client.final(changes=5)
    assert (header["size"], header["samples"]) == ([64, 36], 4)
    words = shlex.split(header["command"])
    assert words[:2] == ["clrt", "render"]
    assert CliRunner().invoke(main, [*words[1:], "-o", "a.png"]).exit_code == 0
    assert Path("a.png").read_bytes() == file
    scene = clrt.load_scene("four-spheres")
    assert (np.asarray(Image.open("a.png")) != clrt.render(scene, 64, 36, dtype="uint8")).any()


def with_alpha() -> Subject:
    scene = clrt.load_scene("four-spheres")
    scene = replace(scene, film=clrt.Film(transparent=True, transfer="srgb"))
    return Subject(("x",), lambda frame: scene)


@pytest.mark.parametrize("served", [with_alpha()], indirect=True, ids=["alpha"])
def test_alpha(served: Served, tmp_path: Path) -> None:
    _, file = opened(served).final()
    (tmp_path / "a.png").write_bytes(file)
    picture = Image.open(tmp_path / "a.png")
    assert (picture.mode, picture.info["srgb"]) == ("RGBA", 0)
    scene = with_alpha().at(0)
    assert (np.asarray(picture) == clrt.render(scene, 64, 36, dtype="uint8")).all()


def test_pick(served: Served) -> None:
    client = opened(served)
    client.final()
    truth = clrt.reference.trace(clrt.load_scene("four-spheres"), 64, 36)
    seen = set()
    for x, y in [(20, 18), (34, 18), (63, 35), (50, 2)]:
        client.say("pick", x=x, y=y)
        found = client.hear()[0]["picked"]
        assert (-1 if found is None else found["index"]) == truth.id[y, x]
        seen.add(truth.id[y, x])
    assert len(seen) > 2
    client.say("pick", x=5000, y=5000)  # on its edge
    assert client.hear()[0]["picked"]["index"] == truth.id[35, 63]


@pytest.mark.parametrize("said", NONSENSE, ids=lambda said: str(said)[:10])
def test_nonsense_ends_that_client(served: Served, said: str | bytes) -> None:
    one, other = opened(served), opened(served)
    one.connection.send(said)
    with pytest.raises(ConnectionClosed):
        one.final(changes=99)
    other.say("turn", x=1, y=1)
    assert other.final(changes=2)


def test_closed_tabs_end_nothing(served: Served) -> None:
    for _ in range(5):
        one = opened(served)
        one.say("sample", samples=16)
        one.connection.socket.shutdown(socket.SHUT_RDWR)  # in the middle of a picture
    other = opened(served)
    assert other.final()


def test_two_clients_move_for_themselves(served: Served) -> None:
    one, other = opened(served), opened(served)
    one.say("turn", x=20, y=0)
    assert one.final(changes=2)[1] != other.final()[1]


def test_an_error_is_told(renderer: clrt.Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    view = View(renderer, lambda: Session(of("four-spheres")), "")

    def fail(*given: Any, **options: Any) -> None:
        raise clrt.OutputError("no memory")

    monkeypatch.setattr(renderer, "render", fail)
    with view.listen("127.0.0.1", 0) as listening, ExitStack() as clients:
        threading.Thread(target=listening.serve_forever).start()
        client = opened(Served(view.address(listening), clients))
        assert client.hear()[0] == {"error": "no memory"}
        monkeypatch.undo()
        client.say("turn", x=1, y=1)
        assert client.final(changes=2)


def test_a_frame_that_cannot_be_read(renderer: clrt.Renderer) -> None:
    """The page is told, and shows the one before."""
    scene = clrt.load_scene("four-spheres")

    def at(frame: int) -> clrt.Scene:
        if frame == 1:
            raise clrt.SceneError("flow.xyz: line 7: expected 3 numbers")
        return scene

    view = View(renderer, lambda: Session(Subject((), at, frames=3)), "")
    with view.listen("127.0.0.1", 0) as listening, ExitStack() as clients:
        threading.Thread(target=listening.serve_forever).start()
        client = opened(Served(view.address(listening), clients))
        client.final()
        client.say("frame", frame=1)
        assert client.hear()[0] == {"error": "flow.xyz: line 7: expected 3 numbers"}
        assert client.final(changes=2)[0]["frame"] == 0


def test_a_port_that_is_taken(renderer: clrt.Renderer) -> None:
    view = View(renderer, lambda: Session(of("four-spheres")), "")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(RequestError, match=f"--port {port}: Address already in use"):
            view.listen("127.0.0.1", port)
    with pytest.raises(RequestError, match="--host nowhere"):
        view.listen("nowhere.invalid", 0)


def test_ctrl_c_frees_the_port(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "clrt", "view", "four-spheres"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    address = process.stdout.readline().strip()
    port = int(address.split(":")[2].split("/")[0])
    with ExitStack() as clients:
        # Browsers connect before they ask for anything.
        clients.enter_context(socket.create_connection(("127.0.0.1", port)))
        client = opened(Served(address, clients))
        client.say("resize", width=2000, height=2000)
        client.say("sample", samples=64)  # it is rendering
        client.hear()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=8)
    assert (process.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "clrt: interrupted"
    socket.create_server(("127.0.0.1", port)).close()
