"""Server: a page, and a socket that a painter paints through, for whoever knows the token."""

import html
import json
import logging
import secrets
from collections.abc import Callable
from contextlib import closing, suppress
from http import HTTPStatus
from string import Template
from typing import Any
from urllib.parse import parse_qs, urlsplit

import msgspec
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve

from clrt import storage
from clrt.errors import RequestError
from clrt.figure.rendering import Renderer
from clrt.viewer.painter import Painter, Stage
from clrt.viewer.session import MESSAGES, Session

MESSAGE = 1024
"""Bytes that a page can say at a time."""
PATIENCE = 1.0
"""Seconds that a browser has to ask for something once it has connected, and to answer when it is
told to go: so Ctrl-C is. Browsers connect ahead of their requests."""

PAGE = Template("""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>$title</title>
<style nonce="$nonce">
:root { color-scheme: light dark; }
body { margin: 0; }
#view { height: 100vh; }
$style</style>
<main id="view"></main>
<script type="module" nonce="$nonce">$script</script>
</html>
""")
POLICY = (
    "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; "
    "connect-src 'self'; img-src blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)


class View:
    """Serves a page; each one that is open has a session of its own."""

    def __init__(self, renderer: Renderer, new_session: Callable[[], Session], title: str) -> None:
        self._stage = Stage(renderer)
        self._new_session = new_session
        self._title = title
        self._token = secrets.token_urlsafe(16)

    def listen(self, host: str, port: int) -> Server:
        """A server that runs as long as a `with` lasts: serve_forever().

        port: 0 takes a free one.

        Raises:
            RequestError: it cannot be there.
        """
        log = logging.Logger("clrt.view", logging.CRITICAL)  # a stranger's bad request is no news
        try:
            return serve(
                self._converse,
                host,
                port,
                process_request=self._answer,
                compression=None,
                max_size=MESSAGE,
                open_timeout=PATIENCE,
                close_timeout=PATIENCE,
                logger=log,
            )
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise RequestError(f"--host {host} --port {port}: {reason}") from None

    def address(self, listening: Server) -> str:
        """The address to open in a browser."""
        host, port = listening.socket.getsockname()[:2]
        name = f"[{host}]" if ":" in host else host
        return f"http://{name}:{port}/?token={self._token}"

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The page, a refusal, or None: a socket is opened."""
        url = urlsplit(request.path)
        given = parse_qs(url.query).get("token", [""])[-1]
        if not secrets.compare_digest(given.encode(), self._token.encode()):
            return connection.respond(HTTPStatus.FORBIDDEN, "The token is not right.\n")
        origin = request.headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != request.headers.get("Host"):
            return connection.respond(HTTPStatus.FORBIDDEN, "Other pages cannot connect.\n")
        if url.path == "/ws":
            return None
        if url.path == "/":
            return self._page()
        return connection.respond(HTTPStatus.NOT_FOUND, "There is nothing here.\n")

    def _page(self) -> Response:
        nonce = secrets.token_urlsafe(16)
        folder = storage.folder("viewer")
        script, socket, style = (
            (folder / name).read_text("utf-8") for name in ("view.js", "socket.js", "view.css")
        )
        body = PAGE.substitute(
            title=html.escape(self._title), nonce=nonce, style=style, script=script + socket
        ).encode()
        headers = {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": POLICY.format(nonce=nonce),
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",  # which would tell the token
            "X-Content-Type-Options": "nosniff",
        }
        return Response(HTTPStatus.OK, "OK", Headers(headers), body)

    def _converse(self, connection: ServerConnection) -> None:
        """With one page, until it goes or talks nonsense."""

        def send(header: dict[str, Any], file: bytes) -> None:
            with suppress(ConnectionClosed):
                connection.send(json.dumps(header).encode() + b"\n" + file)

        session = self._new_session()
        painter = Painter(self._stage, session, send).start()
        with suppress(ConnectionClosed), closing(painter):
            send({"about": session.about}, b"")
            for text in connection:
                try:
                    message = MESSAGES.decode(text)
                except msgspec.DecodeError as error:
                    connection.close(CloseCode.POLICY_VIOLATION, str(error)[:100])
                    break
                painter.tell(message)
