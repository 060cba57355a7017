"""Drive the playground in headless Chromium, from disk, with the network cut off.

    make playground && python benchmarks/playground_in_browser.py out/playground pictures/

Checks that a wrong text is told where it is wrong while it is typed, that `Format` lays it out, and
that examples show their reports; nothing in the console, nothing asked of any host. Writes
pictures at the width of a phone and of a desk. It needs a Chromium on the path.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

WIDTHS = {"phone": 390, "desk": 1400}
WIDEST = (
    "Math.max(...[...document.querySelectorAll('body *')]"
    ".filter((e) => !e.closest('#marks, #text')).map((e) => e.getBoundingClientRect().right))"
)
PATIENCE = 180.0  # s for Python to start, on a busy machine
WRONG = "agent r : single_integrator { start (1, 1) }\nrequire a: always r.x >== 3\n"
LOOSE = "require   a:always r.x>=3\n"


class Browser:
    """A page over the DevTools protocol, by a pair of pipes."""

    def __init__(self, read: int, write: int) -> None:
        self._read, self._write = os.fdopen(read, "rb", buffering=0), write
        self._rest, self._count = b"", 0
        self.console: list[str] = []
        self.asked: set[str] = set()
        self._session: str | None = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            more = self._read.read(1 << 16)
            if not more:
                raise SystemExit("the browser is gone")
            self._rest += more
        line, self._rest = self._rest.split(b"\0", 1)
        return json.loads(line)

    def call(self, method: str, **given: Any) -> dict[str, Any]:
        """The result of one command; events on the way are kept."""
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": given}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            told = self._next()
            if told.get("id") == self._count:
                if "error" in told:
                    raise SystemExit(f"{method}: {told['error']}")
                return told["result"]
            self._heard(told)

    def _heard(self, told: dict[str, Any]) -> None:
        match told.get("method"):
            case "Runtime.exceptionThrown":
                self.console.append(str(told["params"]["exceptionDetails"]))
            case "Runtime.consoleAPICalled" if told["params"]["type"] in ("error", "warning"):
                self.console.append(str([a.get("value") for a in told["params"]["args"]]))
            case "Log.entryAdded":
                self.console.append(told["params"]["entry"]["text"])
            case "Network.requestWillBeSent":
                self.asked.add(told["params"]["request"]["url"].split(":")[0])

    def js(self, text: str) -> Any:
        """The value of an expression."""
        given = {"returnByValue": True, "awaitPromise": True}
        result = self.call("Runtime.evaluate", expression=text, **given)
        if "exceptionDetails" in result:
            raise SystemExit(f"{text}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def until(self, text: str, what: str) -> Any:
        """The value of an expression once it is true."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            value = self.js(text)
            if value:
                return value
            time.sleep(0.1)
        raise SystemExit(f"{what}: not within {PATIENCE:g} s; console {self.console}; "
                         f"state {self.js('document.body.innerText')[:300]}")  # fmt: skip

    def size(self, width: int, height: int = 900) -> None:
        """The screen from now on."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=False)  # fmt: skip

    def picture(self, path: Path) -> None:
        """The whole page as PNG."""
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=True)
        path.write_bytes(base64.b64decode(shot["data"]))


@contextmanager
def browser() -> Iterator[Browser]:
    """Chromium, gone at the end."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        raise SystemExit("there is no chromium on the path")
    to_it, from_us = os.pipe()
    to_us, from_it = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        words = [program, "--headless", "--no-sandbox", "--disable-gpu"]
        words += [f"--user-data-dir={profile}", "--remote-debugging-pipe"]
        words += ["--host-resolver-rules=MAP * ~NOTFOUND"]

        def pipes() -> None:
            os.dup2(to_it, 103)
            os.dup2(from_it, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        process = subprocess.Popen(words, preexec_fn=pipes, pass_fds=(3, 4),
                                   stderr=subprocess.DEVNULL)  # fmt: skip
        os.close(to_it)
        os.close(from_it)
        try:
            yield Browser(to_us, from_us)
        finally:
            process.terminate()
            process.wait()


def write(page: Browser, text: str) -> str:
    """Type a text in; how many problems are shown then."""
    page.js("delete document.body.dataset.problems")
    page.js(f"text.value = {json.dumps(text)}; text.dispatchEvent(new Event('input'))")
    return page.until("document.body.dataset.problems", "an answer to a text")


def typed(page: Browser, pictures: Path) -> Iterator[str]:
    """What is wrong with how texts are told and laid out."""
    if write(page, WRONG) == "0":
        yield "a wrong text has no problem"
    shown = page.js("at('problems').innerText")
    if "2:" not in shown or "error[" not in shown:
        yield f"the problem has no place: {shown}"
    if page.js("marks.querySelectorAll('mark').length") == 0:
        yield "the wrong words are not marked"
    page.picture(pictures / "wrong.png")
    write(page, LOOSE)
    page.js("at('format').click()")
    page.until("text.value === 'require a: always r.x >= 3\\n'", "the text laid out")


def chosen(page: Browser) -> Iterator[str]:
    """What is wrong with the examples."""
    for k in range(page.js("STLC.examples.length")):
        name = page.js(f"STLC.examples[{k}].name")
        page.js("delete document.body.dataset.problems")
        page.js(f"at('example').value = {k}; at('example').onchange()")
        if page.until("document.body.dataset.problems", name) != "0":
            yield f"{name}: {page.js('at(`problems`).innerText')}"
        kept = page.js(f"STLC.examples[{k}].report !== null")
        if kept and not page.js("at('report').srcdoc.includes('id=\"map\"')"):
            yield f"{name} has no report"


def fitted(page: Browser, pictures: Path) -> Iterator[str]:
    """What is wider than the screen."""
    time.sleep(1.0)  # the report draws itself
    for name, width in WIDTHS.items():
        page.size(width)
        time.sleep(0.5)
        page.picture(pictures / f"{name}.png")
        wide = page.js(WIDEST)
        if wide > width:
            yield f"{name}: {wide} px wide on a screen of {width}"


def check(folder: Path, pictures: Path) -> list[str]:
    """What is wrong with the playground in a folder."""
    with browser() as page:
        page.size(WIDTHS["desk"])
        began = time.monotonic()
        page.call("Page.navigate", url=(folder / "index.html").resolve().as_uri())
        version = page.until("document.body?.dataset.ready", "Python in the browser")
        print(f"Python {version} after {time.monotonic() - began:.1f} s")
        wrong = [*typed(page, pictures), *chosen(page), *fitted(page, pictures), *page.console]
        others = page.asked - {"file", "data", "blob", "about"}
        return [*wrong, f"asked others: {others}"] if others else wrong


def main() -> int:
    """Exit 1 if anything is wrong."""
    folder, pictures = map(Path, sys.argv[1:])
    pictures.mkdir(parents=True, exist_ok=True)
    wrong = check(folder, pictures)
    print("\n".join(wrong) or f"nothing wrong; look at {pictures}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
