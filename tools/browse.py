"""Look at built pages in headless Chromium with networking off.

    python tools/browse.py HTML [SHOTS]

Opens every page of the folder ``HTML`` at the width of a desk and of a phone, prints what is wrong
with it, and with ``SHOTS`` stores a picture of each there. Exit code 1 if anything is wrong. Needs
Chromium (Debian: apt-get install chromium).
"""

import base64
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

from websocket import WebSocket, create_connection

WIDTHS = {"desk": 1280, "phone": 390}
PATIENCE = 30.0  # s, for one page

# the theme declares this constant in two of its own scripts
KNOWN_CONSOLE = ("THEBE_JS_URL",)

# what a page says about itself once its formulas are drawn
PROBE = """(async () => {
  const math = document.querySelectorAll('.math').length;
  if (math && window.MathJax && MathJax.startup) await MathJax.startup.promise;
  await document.fonts.ready;
  document.getAnimations().forEach(a => a.finish());  // the side bar slides in
  return {
    math, drawn: document.querySelectorAll('mjx-container').length,
    errors: document.querySelectorAll('mjx-merror').length,
    images: [...document.images].filter(i => i.loading !== 'lazy' && !i.naturalWidth)
      .map(i => i.src),
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    height: document.documentElement.scrollHeight,
  };
})()"""


@dataclass
class Visit:
    """What was wrong with a page, and its picture."""

    page: str
    width: int
    problems: list[str] = field(default_factory=list)
    picture: bytes = b""


class Tab:
    """A browser tab, driven through the DevTools protocol."""

    def __init__(self, socket: WebSocket) -> None:
        """Listen to everything the tab asks for and complains about."""
        self._socket = socket
        self._number = 0
        self.events: list[dict[str, Any]] = []
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; events that come first are kept."""
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv())
            if message.get("id") == self._number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message["result"]
            self.events.append(message)

    def wait(self, event: str) -> None:
        """Wait until an event has come."""
        while not any(message.get("method") == event for message in self.events):
            self.events.append(json.loads(self._socket.recv()))

    def _resize(self, width: int, height: int) -> None:
        self.send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=width < 600,
        )

    def visit(self, page: Path, width: int, picture: bool = False) -> Visit:
        """Open a page and collect what is wrong with it."""
        found = Visit(page.name, width)
        self.send("Page.navigate", url="about:blank")
        self._resize(width, 900)
        self.events.clear()
        self.send("Page.navigate", url=page.as_uri())
        self.wait("Page.loadEventFired")
        state = self.send(
            "Runtime.evaluate", expression=PROBE, awaitPromise=True, returnByValue=True
        )["result"]["value"]
        found.problems = [*_complaints(self.events), *_faults(state)]
        if picture:
            # a window as high as the page: a clip beyond the window shifts what is fixed in it
            self._resize(width, state["height"])
            shot = self.send("Page.captureScreenshot")
            found.picture = base64.b64decode(shot["data"])
        return found


def _complaints(events: list[dict[str, Any]]) -> Iterator[str]:
    for message in events:
        about = message.get("params", {})
        match message.get("method"):
            case "Network.requestWillBeSent":
                url = about["request"]["url"]
                if not url.startswith(("file:", "data:", "blob:")):
                    yield f"asks for {url}"
            case "Network.loadingFailed":
                yield f"could not load a file: {about['errorText']}"
            case "Log.entryAdded":
                entry = about["entry"]
                if entry["level"] == "error" and not _known(entry["text"]):
                    yield f"console: {entry['text']} {entry.get('url', '')}"
            case "Runtime.exceptionThrown":
                detail = about["exceptionDetails"]
                text = detail.get("exception", {}).get("description", detail["text"])
                if not _known(text):
                    yield f"script: {text}"
            case "Runtime.consoleAPICalled" if about["type"] == "error":
                text = " ".join(str(a.get("value", a.get("description"))) for a in about["args"])
                if not _known(text):
                    yield f"console: {text}"


def _known(text: str) -> bool:
    return any(known in text for known in KNOWN_CONSOLE)


def _faults(state: dict[str, Any]) -> Iterator[str]:
    if state["drawn"] < state["math"]:
        yield f"{state['math'] - state['drawn']} of {state['math']} formulas are not drawn"
    if state["errors"]:
        yield f"{state['errors']} formulas hold an error"
    if state["overflow"] > 0:
        yield f"wider than the screen by {state['overflow']} px"
    yield from (f"image not drawn: {source}" for source in state["images"])


@contextmanager
def chromium() -> Iterator[Tab]:
    """Start a browser without a profile and without a network; yield its one tab."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        raise FileNotFoundError(
            "Expected Chromium, found none. Install it (Debian: apt-get install chromium)."
        )
    flags = (
        "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync"
        " --disable-background-networking --disable-component-update --disable-extensions"
        " --disable-dev-shm-usage --hide-scrollbars --remote-debugging-port=0"
        " --remote-allow-origins=* --proxy-server=127.0.0.1:9"
    )
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [program, *flags.split(), f"--user-data-dir={profile}", "about:blank"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            port = _port(Path(profile) / "DevToolsActivePort", process)
            request = Request(f"http://127.0.0.1:{port}/json/new?about:blank", method="PUT")
            with urlopen(request, timeout=PATIENCE) as answer:
                address = json.load(answer)["webSocketDebuggerUrl"]
            socket = create_connection(address, timeout=PATIENCE)
            try:
                yield Tab(socket)
            finally:
                socket.close()
        finally:
            process.terminate()
            process.wait(timeout=PATIENCE)


def _port(announced: Path, process: "subprocess.Popen[bytes]") -> int:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        if announced.is_file() and (lines := announced.read_text().split()):
            return int(lines[0])
        time.sleep(0.1)
    raise RuntimeError("Expected Chromium to start, got no answer. Start it by hand to see why.")


def pages(html: Path) -> list[Path]:
    """Return the pages of a built book, without the one that only sends on to the first."""
    found = [page for page in html.resolve().rglob("*.html") if "_static" not in page.parts]
    refresh = 'http-equiv="refresh"'
    return sorted(p for p in found if refresh not in p.read_text(encoding="utf-8").lower())


def main(html: Path, shots: Path | None) -> int:
    """Look at every page; return the exit code."""
    wrong = 0
    with chromium() as tab:
        for page in pages(html):
            for name, width in WIDTHS.items():
                visit = tab.visit(page, width, picture=shots is not None)
                if shots is not None:
                    shots.mkdir(parents=True, exist_ok=True)
                    (shots / f"{page.stem}-{name}.png").write_bytes(visit.picture)
                wrong += bool(visit.problems)
                for problem in visit.problems:
                    print(f"{page.relative_to(html.resolve())} ({name}): {problem}")
    print(f"{len(pages(html))} pages at {len(WIDTHS)} widths, {wrong} with something wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None))
