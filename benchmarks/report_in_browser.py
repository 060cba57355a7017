"""Open reports in headless Chromium: nothing in the console, nothing wider than the screen.

    python benchmarks/report_in_browser.py mission.stl plan.json pictures/

Writes a picture of the page at the width of a phone and of a desk, to be looked at. It needs a
Chromium on the path (Debian: `apt-get install chromium`), which the tests don't: they run the
page's script in V8 (tests/report).
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from stlc.api import load
from stlc.plan import read_plan
from stlc.report import report_page

WIDTHS = {"phone": 390, "desk": 1400}
HEIGHT = 2400
_PROBE = (
    "<script>document.title = 'wide ' + document.documentElement.scrollWidth + ' of ' + "
    "window.innerWidth</script></body>"
)


def _chromium(*words: str) -> subprocess.CompletedProcess[str]:
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        raise SystemExit("there is no chromium on the path")
    common = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    common += ["--virtual-time-budget=3000", "--enable-logging=stderr"]
    return subprocess.run(
        [program, *common, *words], capture_output=True, text=True, timeout=120, check=True
    )


def check(page: Path, folder: Path) -> list[str]:
    """What is wrong with a page; pictures of it go to `folder`."""
    wrong = []
    for name, width in WIDTHS.items():
        size = f"--window-size={width},{HEIGHT}"
        address = f"{page.as_uri()}#t=2.5"
        shot = _chromium(size, f"--screenshot={folder / f'{name}.png'}", address)
        wrong += [f"{name}: {line}" for line in shot.stderr.splitlines() if "CONSOLE" in line]
        dom = _chromium(size, "--dump-dom", address).stdout
        title = re.search(r"<title>wide (\d+) of (\d+)", dom)
        if title is None:
            wrong.append(f"{name}: the page's script did not end")
        elif int(title[1]) > int(title[2]):
            wrong.append(f"{name}: {title[1]} px wide on a screen of {title[2]}")
    return wrong


def main() -> int:
    """Exit 1 if anything is wrong."""
    mission, plan, folder = sys.argv[1:]
    Path(folder).mkdir(parents=True, exist_ok=True)
    html = report_page(load(mission), read_plan(plan)).replace("</body>", _PROBE)
    with tempfile.TemporaryDirectory() as scratch:
        page = Path(scratch) / "report.html"
        page.write_text(html, encoding="utf-8")
        wrong = check(page, Path(folder).resolve())
    print("\n".join(wrong) or f"nothing wrong; look at {folder}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
