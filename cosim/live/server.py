"""Serves a live page to browsers of this machine: the page, its events (Server-Sent Events), and its steps.

The standard library's server suffices for a few pages: a web framework would be a dependency for three addresses. It
is bound to 127.0.0.1 only. Requests without the token of the printed address are refused. So are requests that name
another host (a page of another site could reach this server under its own name), and steps that come from another page.
"""
import hmac
import json
import secrets
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import BoundedSemaphore, Thread, current_thread
from time import monotonic
from typing import Any
from urllib.parse import parse_qs, urlsplit

from ..errors import UsageError
from ..text import shortened
from .feed import Feed

HOST = "127.0.0.1"
MOST_CONNECTIONS, MOST_PAGES = 16, 4
MOST_BYTES = 1000   # of a request's body
PATIENCE_S = 10.0   # for a browser that sends or takes nothing
LAST_S = 1.0        # for pages to be told the end


class Refused(Exception):
    """A request that is refused: its status, and one sentence."""

    def __init__(self, status: int, sentence: str):
        super().__init__(sentence)
        self.status = status


class Server(ThreadingHTTPServer):
    """Serves `page` and the events of `feed` in threads, from `begin` to `end`."""
    daemon_threads = True
    block_on_close = False

    def __init__(self, page: str, policy: str, feed: Feed):
        super().__init__((HOST, 0), Handler)
        self.page, self.policy, self.feed = page, policy, feed
        self.token = secrets.token_urlsafe(16)
        self.host = f"{HOST}:{self.server_address[1]}"
        self.address = f"http://{self.host}/?token={self.token}"
        self.connections, self.pages = BoundedSemaphore(MOST_CONNECTIONS), BoundedSemaphore(MOST_PAGES)
        self.readers: set[Thread] = set()

    def begin(self) -> None:
        """Begin to serve."""
        Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()

    def end(self) -> None:
        """Close the feed, wait LAST_S for pages to be told the end, and serve no more."""
        self.feed.close()
        self.shutdown()
        self.server_close()
        until = monotonic() + LAST_S
        for reader in list(self.readers):
            reader.join(max(0.0, until - monotonic()))

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread, unless there are too many."""
        if self.connections.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """What the thread does."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self.connections.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that is gone is no error; anything else ends that request only."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            print(f"ahv: the live page could not answer a request: {error!r}", file=sys.stderr)


class Handler(BaseHTTPRequestHandler):
    """One request."""
    server: Server
    timeout = PATIENCE_S
    server_version, sys_version = "ahv", ""

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing: addresses have the token in them."""

    def do_GET(self) -> None:
        """The page or its events."""
        self.answer({"/": self.send_page, "/events": self.send_events})

    def do_POST(self) -> None:
        """A step."""
        self.answer({"/step": self.take_step})

    def answer(self, known: dict[str, Any]) -> None:
        """Carry out what the request's path is known for, or refuse it in a sentence."""
        try:
            self.check_sender()
            path = urlsplit(self.path).path
            if path not in known:
                raise Refused(404, f"There is nothing at {shortened(path, 60)}.")
            known[path]()
        except Refused as refused:
            self.send(refused.status, "application/json", json.dumps({"error": str(refused)}))

    def check_sender(self) -> None:
        """Raises Refused for a request without the token, for another host, or from another page."""
        try:
            given = parse_qs(urlsplit(self.path).query, max_num_fields=4).get("token", [])
        except ValueError:
            given = []
        known = self.server.token.encode()
        if len(given) != 1 or not hmac.compare_digest(given[0].encode("utf-8", "replace"), known):
            raise Refused(403, "The address needs the token that ahv has printed.")
        if self.headers.get_all("Host") != [self.server.host]:
            raise Refused(403, f"The host must be {self.server.host}.")
        origins = self.headers.get_all("Origin", [])
        if origins != [f"http://{self.server.host}"] and (origins or self.command == "POST"):
            raise Refused(403, f"The request must come from the page at http://{self.server.host}.")

    def send_page(self) -> None:
        """The page."""
        self.send(200, "text/html", self.server.page)

    def send_events(self) -> None:
        """Everything that the feed has for a page, to the end."""
        if not self.server.pages.acquire(blocking=False):
            raise Refused(503, f"At most {MOST_PAGES} pages can be open at a time.")
        me = current_thread()
        self.server.readers.add(me)
        try:
            self.head(200, "text/event-stream")
            for text in self.server.feed.messages():
                self.wfile.write(f"data: {text}\n\n".encode() if text else b":\n\n")
        finally:
            self.server.readers.discard(me)
            self.server.pages.release()

    def take_step(self) -> None:
        """Ask for an offset of an input: {"input": name, "value": offset}."""
        asked = self.body()
        if not isinstance(asked, dict) or set(asked) != {"input", "value"}:
            raise Refused(400, 'A step is {"input": NAME, "value": NUMBER}.')
        feed, name, value = self.server.feed, asked["input"], asked["value"]
        lever = next((x for x in feed.board.levers if x.input == name), None)
        if lever is None:
            raise Refused(400, f"{shortened(str(name), 60)} is no input that can be stepped; there are "
                               f"{', '.join(x.input for x in feed.board.levers) or 'none'}.")
        if isinstance(value, bool) or not isinstance(value, int | float) or not -lever.most <= value <= lever.most:
            raise Refused(400, f"{name}: the offset {shortened(str(value), 60)} is not allowed; it must be a number "
                               f"from {-lever.most:g} to {lever.most:g}.")
        if feed.end is not None:
            raise Refused(409, "The flight is over: nothing can be stepped.")
        try:
            feed.desk.ask(name, float(value))
        except UsageError as error:
            raise Refused(400, str(error)) from None
        self.send(200, "application/json", json.dumps({"input": name, "value": float(value)}))

    def body(self) -> Any:
        """The request's JSON. Raises Refused for anything else, and for more than MOST_BYTES."""
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit()) or "Transfer-Encoding" in self.headers:
            raise Refused(411, "A step needs its length in bytes.")
        if len(length) > 9 or int(length) > MOST_BYTES:
            raise Refused(413, f"A step has at most {MOST_BYTES} bytes.")
        if self.headers.get_content_type() != "application/json":
            raise Refused(415, "A step is application/json.")
        try:
            return json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            raise Refused(400, "The step is not JSON.") from None

    def send(self, status: int, kind: str, text: str) -> None:
        """A whole answer."""
        content = text.encode()
        self.head(status, kind, len(content))
        self.wfile.write(content)

    def head(self, status: int, kind: str, length: int | None = None) -> None:
        """The beginning of an answer."""
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in (("Content-Security-Policy", self.server.policy), ("Cache-Control", "no-store"),
                            ("X-Content-Type-Options", "nosniff"), ("Referrer-Policy", "no-referrer"),
                            ("Cross-Origin-Resource-Policy", "same-origin"), ("Connection", "close")):
            self.send_header(name, value)
        self.end_headers()
