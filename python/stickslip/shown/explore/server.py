"""The server of a page on this machine alone: loopback, a token in the address, no other Host or Origin."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import Any

from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPMessageDelegate, HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.routing import Router
from tornado.web import ErrorHandler

LOOPBACK = "127.0.0.1"


class Guard(Router):
    """Lets a request pass that was meant for this address, as a page of this address or a person sends it."""

    def __init__(self, inner: BokehTornado, port: int) -> None:
        self.inner = inner
        self.hosts = (f"{LOOPBACK}:{port}", f"localhost:{port}")

    def find_handler(self, request: HTTPServerRequest, **_: Any) -> HTTPMessageDelegate | None:
        """The page's handler, or one that answers 403 where Host or Origin is another's."""
        origin = request.headers.get("Origin")
        known = origin is None or origin in {f"http://{host}" for host in self.hosts}
        if request.host in self.hosts and known:
            passed: HTTPMessageDelegate | None = self.inner.find_handler(request)
            return passed
        refused: HTTPMessageDelegate = self.inner.get_handler_delegate(
            request, ErrorHandler, {"status_code": 403}
        )
        return refused


def serve(made: Callable[[Document], None], port: int = 0) -> tuple[BaseServer, str]:
    """Start a server of one page.

    Parameters
    ----------
    made : callable
        Fills a document for each visitor.
    port : int
        0 takes a free one.

    Returns
    -------
    tuple
        The server, whose `io_loop` is to be started, and the address with its token.

    Raises
    ------
    OSError
        The port is taken.
    """
    token = secrets.token_urlsafe(24)
    sockets = bind_sockets(port, LOOPBACK)
    bound = int(sockets[0].getsockname()[1])
    inner = BokehTornado(
        {"/": made}, prefix=f"/{token}", extra_websocket_origins=[f"{LOOPBACK}:{bound}", f"localhost:{bound}"]
    )
    http = HTTPServer(Guard(inner, bound))
    http.add_sockets(sockets)
    server = BaseServer(IOLoop.current(), inner, http)
    server.start()
    return server, f"http://{LOOPBACK}:{bound}/{token}/"
