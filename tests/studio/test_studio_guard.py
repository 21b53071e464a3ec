"""Who may speak to a studio, tried from outside as a web page would try it."""

from __future__ import annotations

import base64
import http.client
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("starlette")

from websockets.exceptions import ConnectionClosed

from i2pdsl.studio.protocol import LARGEST_MESSAGE
from i2pdsl.studio.serve import kept_token
from studio_for_tests import Served, Talk, fill

Headers = dict[str, str] | list[tuple[str, str]]


def asked(
    served: Served, method: str = "GET", path: str = "/", headers: Headers | None = None
) -> http.client.HTTPResponse:
    """A raw request; `Host` is the studio's own unless given otherwise."""
    connection = http.client.HTTPConnection("127.0.0.1", int(served.port), timeout=20)
    pairs = list(headers.items()) if isinstance(headers, dict) else list(headers or ())
    if not any(name.lower() == "host" for name, _ in pairs):
        pairs.insert(0, ("Host", f"127.0.0.1:{served.port}"))
    connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
    for name, value in pairs:
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    answer.body = answer.read()  # type: ignore[attr-defined]
    connection.close()
    return answer


def handshake(served: Served, **other: str | None) -> int:
    """The status of an attempt to open the socket; None leaves a header out."""
    token = served.address.partition("#")[2]
    usual: dict[str, str | None] = {
        "Host": f"127.0.0.1:{served.port}",
        "Origin": f"http://127.0.0.1:{served.port}",
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": base64.b64encode(b"0123456789abcdef").decode(),
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Protocol": f"i2p, i2p.token.{token}",
    }
    given = {name: value for name, value in {**usual, **other}.items() if value is not None}
    return asked(served, path="/socket", headers=given).status


def test_the_right_handshake(served: Served) -> None:
    assert handshake(served) == 101
    own = f"localhost:{served.port}"
    assert handshake(served, Host=own, Origin=f"http://{own}") == 101


def test_wrong_handshakes(served: Served) -> None:
    port = served.port
    token = served.address.partition("#")[2]
    for other in (
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": None},
        {"Origin": f"https://127.0.0.1:{port}"},
        {"Origin": f"http://127.0.0.1:{int(port) + 1}"},
        {"Origin": f"http://localhost:{port}"},  # of another host than is spoken to
        {"Origin": f"http://127.0.0.1:{port}.evil.example"},
        {"Host": "evil.example"},
        {"Host": f"evil.example:{port}", "Origin": f"http://evil.example:{port}"},
        {"Host": "127.0.0.1"},
        {"Sec-WebSocket-Protocol": None},
        {"Sec-WebSocket-Protocol": "i2p"},
        {"Sec-WebSocket-Protocol": "i2p, i2p.token."},
        {"Sec-WebSocket-Protocol": f"i2p, i2p.token.{token[:-1]}"},
        {"Sec-WebSocket-Protocol": f"i2p, i2p.token.{token}x"},
        {"Sec-WebSocket-Protocol": f"i2p.token.{token}"},
        {"Sec-WebSocket-Protocol": f"i2p, i2p.token.{token.swapcase()}"},
    ):
        assert handshake(served, **other) == 403, other


def test_hosts(served: Served) -> None:
    assert asked(served).status == 200
    assert asked(served, headers={"Host": f"localhost:{served.port}"}).status == 200
    for host in ("evil.example", f"evil.example:{served.port}", "127.0.0.1", "localhost", ""):
        assert asked(served, headers={"Host": host}).status in (400, 403), host
    twice = [("Host", f"127.0.0.1:{served.port}"), ("Host", "evil.example")]
    assert asked(served, headers=twice).status in (400, 403)
    assert asked(served, headers={"Origin": "https://evil.example"}).status == 403


def test_nothing_is_changed_by_http(served: Served) -> None:
    before = {path: path.read_bytes() for path in served.folder.rglob("*") if path.is_file()}
    for method in ("POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"):
        for path in ("/", "/socket", "/help.story", "/made/x/y"):
            assert asked(served, method, path).status in (400, 404, 405), (method, path)
    for path in ("/socket", "/i2p/save?path=help.story&text=x", "/made/x/y"):
        assert asked(served, path=path).status == 404
    assert before == {
        path: path.read_bytes() for path in served.folder.rglob("*") if path.is_file()
    }


def test_only_the_studio_s_own_files_are_served(served: Served) -> None:
    assert asked(served, path="/render/page/player.js").status == 200
    for path in (
        "/help.story",
        "/render/film_page.py",
        "/render/../studio/serve.py",
        "/../../../../etc/passwd",
        "/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/render/page/player.js%00.png",
        "/made//etc/passwd",
        "/made/..%2f..%2f/x",
    ):
        assert asked(served, path=path).status == 404, path


def test_the_policy(served: Served) -> None:
    for path in ("/", "/render/page/player.js", "/nothing"):
        answer = asked(served, path=path)
        policy = answer.getheader("content-security-policy") or ""
        rules = dict(rule.strip().partition(" ")[::2] for rule in policy.split(";"))
        assert rules["default-src"] == "'none'"
        assert rules["script-src"] == "'self'"
        assert [name for name in rules if "unsafe" in rules[name]] == ["style-src-attr"]
        assert rules["frame-ancestors"] == rules["base-uri"] == rules["form-action"] == "'none'"
        assert answer.getheader("x-content-type-options") == "nosniff"
        assert answer.getheader("referrer-policy") == "no-referrer"
        assert answer.getheader("server") is None
    page = asked(served).body.decode()  # type: ignore[attr-defined]
    assert all("src=" in script for script in re.findall(r"<script[^>]*>", page))
    assert not re.search(r"<script[^>]*>[^<]", page)
    assert not re.search(r"\son\w+=|javascript:|https?://", page)


def answer_to(served: Served, frame: bytes) -> int:
    """The code with which a connection is closed after the beginning of a message."""
    token = served.address.partition("#")[2]
    place = f"127.0.0.1:{served.port}"
    lines = (
        "GET /socket HTTP/1.1",
        f"Host: {place}",
        f"Origin: http://{place}",
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==",
        "Sec-WebSocket-Version: 13",
        f"Sec-WebSocket-Protocol: i2p, i2p.token.{token}",
    )
    with socket.create_connection(("127.0.0.1", int(served.port)), timeout=20) as connection:
        connection.sendall("\r\n".join((*lines, "", "")).encode())
        reader = connection.makefile("rb")
        assert reader.readline().startswith(b"HTTP/1.1 101")
        while reader.readline().strip():
            pass
        connection.sendall(frame)
        kind, _ = reader.read(2)
        assert kind == 0x88  # close
        return int.from_bytes(reader.read(2))


def sent(talk: Talk, message: str | bytes) -> None:
    talk.socket.send(message)
    talk.listen()


def test_messages_that_are_too_large_or_none(served: Served) -> None:
    with Talk(served.address) as talk:
        for text in ("", "{", "[]", "7", '{"jsonrpc": "1.0"}', "[" * 100_000):
            talk.socket.send(text)
            heard = talk.listen()
            while "method" in heard:  # the server tells all pages what others do
                heard = talk.listen()
            assert heard["error"]["code"] == -32600
        talk.tell("exit", {})  # ends a language server, and not the studio
        assert talk.ask("i2p/studio")["protocol"] == 1
    too_large = b"\x81\xff" + (LARGEST_MESSAGE + 1).to_bytes(8) + b"mask"  # RFC 6455, 5.2
    assert answer_to(served, too_large) == 1009
    with Talk(served.address) as talk, pytest.raises(ConnectionClosed):
        sent(talk, b"bytes")
    with Talk(served.address) as talk:
        assert talk.ask("i2p/studio")["protocol"] == 1


@pytest.fixture(scope="module")
def another(tmp_path_factory: pytest.TempPathFactory, served: Served) -> Iterator[Served]:
    studio = Served(fill(tmp_path_factory.mktemp("others")))
    studio.start()
    yield studio
    studio.kill()


def test_a_second_studio_takes_another_port(served: Served, another: Served) -> None:
    assert another.port != served.port
    # Neither knows the other's token.
    token = served.address.partition("#")[2]
    wrong = {"Sec-WebSocket-Protocol": f"i2p, i2p.token.{token}"}
    assert handshake(another, **wrong) == 403
    with Talk(another.address) as talk:
        assert talk.ask("i2p/studio")["folder"] == another.folder.name


def test_it_listens_on_the_loopback_only(served: Served) -> None:
    own = [found[4][0] for found in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)]
    for address in own:
        if not str(address).startswith("127."):
            with pytest.raises(OSError, match=r"refused|timed out|unreachable"):
                socket.create_connection((address, int(served.port)), timeout=5).close()


def ran(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "i2pdsl", "studio", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def test_other_hosts_are_refused(tmp_path: Path) -> None:
    told = ran(str(tmp_path), "--no-browser", "--host", "0.0.0.0")
    assert told.returncode == 2
    assert "--i-know" in told.stderr
    assert "nothing is encrypted" in told.stderr
    assert told.stdout == ""
    told = ran(str(tmp_path), "--no-browser", "--host", "0.0.0.0", "--i-know")
    assert told.returncode == 2
    assert "name the address" in told.stderr


def test_a_port_that_is_taken_and_a_place_that_is_none(served: Served, tmp_path: Path) -> None:
    told = ran(str(tmp_path), "--no-browser", "--port", served.port)
    assert told.returncode == 1
    assert told.stderr.startswith("error: ")
    assert "Traceback" not in told.stderr
    for place in ("nothing-there", "nothing-there/a.story", "a.txt"):
        assert ran(str(tmp_path / place), "--no-browser").returncode == 2


def test_tokens(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder's own, that nobody else could have read or put there."""
    monkeypatch.setattr("platformdirs.user_state_path", lambda name: tmp_path / name)
    token = kept_token(tmp_path)
    assert len(token) == 32
    assert kept_token(tmp_path) == token
    assert kept_token(tmp_path.parent) != token
    (path, _) = sorted(
        (tmp_path / "i2pdsl" / "studio").iterdir(), key=lambda p: p.read_text() != token
    )
    assert path.stat().st_mode & 0o077 == 0
    path.chmod(0o644)
    other = kept_token(tmp_path)
    assert other != token
    path.unlink()
    path.symlink_to(tmp_path / "planted")
    (tmp_path / "planted").write_text("x" * 32)
    assert kept_token(tmp_path) not in (token, other, "x" * 32)
    assert (tmp_path / "planted").read_text() == "x" * 32
