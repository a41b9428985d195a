"""Open a report in a headless browser, without network.

`python tests/support/browser.py out/report.html [folder]` opens it at two widths, light and then dark with
reduced motion, prints the faults, and writes screenshots of the first screen and of the whole page to the
folder. It drives Chromium by the DevTools protocol through a pipe, with the standard library alone.
"""

import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from select import select
from typing import Any

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
SIZES = ((400, 800), (1400, 900))
ERRORS = (
    "Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled", "Network.loadingFailed",
)  # fmt: skip
TIMEOUT = 60.0  # of an answer [s]

PROBE = """
(async () => {
  const transforms = () => [...document.querySelectorAll(".cca-run svg")].map((svg) =>
    [...svg.querySelectorAll(".world, .car")].map((part) => part.getAttribute("transform")).join());
  const seek = (range, t) => { range.value = t; range.dispatchEvent(new Event("input", {bubbles: true})); };
  const roots = [...document.querySelectorAll(".cca")];
  const moved = [], crowded = [];
  let starts = null, keys = null;
  if (roots.length) {
    const button = roots[0].querySelector("button"), range = roots[0].querySelector("input");
    roots[0].scrollIntoView();
    await new Promise((done) => setTimeout(done, 500));
    starts = button.textContent === "Pause" && Number(range.value) > 0;
    const press = (key) => roots[0].dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
    press("End");
    keys = range.value === range.max && button.textContent === "Replay";
    press("Home");
    keys = keys && Number(range.value) === 0;
    press(" ");
    keys = keys && button.textContent === "Pause";
    press(" ");
  }
  for (const root of roots) {
    const range = root.querySelector("input");
    seek(range, 0);
    const before = transforms();
    seek(range, Number(range.max));
    const after = transforms();
    const own = [...root.querySelectorAll(".cca-run svg")].map((svg) =>
      [...document.querySelectorAll(".cca-run svg")].indexOf(svg));
    moved.push(own.every((i) => before[i] !== after[i]));
    for (const part of [0, 0.3, 0.5, 0.7, 1]) {
      seek(range, part * Number(range.max));
      for (const svg of root.querySelectorAll("svg")) {
        const frame = svg.getBoundingClientRect();
        const texts = [...svg.querySelectorAll(".labels text")].filter((e) => e.textContent);
        const boxes = texts.map((e) => e.getBoundingClientRect());
        boxes.forEach((a, i) => {
          if (a.left < frame.left - 1 || a.right > frame.right + 1 || a.top < frame.top - 1) {
            crowded.push("cut off: " + texts[i].textContent);
          }
          boxes.slice(i + 1).forEach((b, j) => {
            const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
            const tall = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
            if (Math.min(wide, tall) > 4) {
              crowded.push(texts[i].textContent + " on " + texts[i + 1 + j].textContent);
            }
          });
        });
      }
    }
    seek(range, 0);
  }
  let plays = null;
  if (roots.length) {
    const button = roots[0].querySelector("button"), before = transforms()[0];
    roots[0].scrollIntoView();
    button.click();
    await new Promise((done) => setTimeout(done, 700));
    plays = transforms()[0] !== before && button.textContent === "Pause";
    button.click();
    window.scrollTo(0, 0);
  }
  const wide = [...document.querySelectorAll("body *")].filter((e) => !e.closest("svg") &&
    e.getBoundingClientRect().right > window.innerWidth + 1).map((e) => e.tagName + "." + e.className);
  const broken = [...document.images].filter((i) => !i.complete || !i.naturalWidth).length;
  const top = [...document.querySelectorAll("[data-first]")].map((e) => e.getBoundingClientRect().top);
  return {width: window.innerWidth, page: document.documentElement.scrollWidth,
    wide, broken, moved, crowded, starts, keys, plays,
    height: document.documentElement.scrollHeight, images: document.images.length, top,
    text: document.body.innerText.slice(0, 600),
    nan: [document.body.innerText, ...[...document.querySelectorAll("svg")].map((e) => e.outerHTML)]
      .some((text) => /NaN|undefined|Infinity/.test(text)),
    requests: performance.getEntriesByType("resource").map((e) => e.name)
      .filter((name) => !name.startsWith("data:"))};
})()
"""


class Browser:
    """A headless Chromium, driven through a pipe."""

    def __init__(self, program: str) -> None:
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        options = "--headless=new --no-sandbox --disable-gpu --hide-scrollbars --remote-debugging-pipe"
        command = f'exec "$0" {options} --user-data-dir="$1" about:blank 3<&{theirs_in} 4>&{theirs_out}'
        self._process = subprocess.Popen(
            ["bash", "-c", command, program, self._folder.name], pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs_in)
        os.close(theirs_out)
        self._buffer, self._count, self.messages = b"", 0, list[dict[str, Any]]()
        self._session: str | None = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(TIMEOUT)
        os.close(self._in)
        os.close(self._out)
        self._folder.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its result; messages of the page in between go to `messages`."""
        self._count += 1
        message: dict[str, Any] = {"id": self._count, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                result: dict[str, Any] = answer["result"]
                return result
            self.messages.append(answer)

    def wait_for(self, method: str) -> None:
        """Wait for a message of the page."""
        while not any(message.get("method") == method for message in self.messages):
            self.messages.append(self._next())

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression in the page, or of its promise."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def picture(self, file: Path, **options: Any) -> None:
        """Write a screenshot."""
        data = self.call("Page.captureScreenshot", format="png", **options)["data"]
        file.write_bytes(base64.b64decode(data))

    @property
    def errors(self) -> list[dict[str, Any]]:
        """Messages about errors in the console and on the network."""
        return [message for message in self.messages if message.get("method") in ERRORS]

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            if not select([self._in], [], [], TIMEOUT)[0]:
                raise TimeoutError("the browser does not answer")
            data = os.read(self._in, 1 << 20)
            if not data:
                raise RuntimeError("the browser has ended")
            self._buffer += data
        message, _, self._buffer = self._buffer.partition(b"\0")
        answer: dict[str, Any] = json.loads(message)
        return answer


def find_browser() -> str | None:
    """Return the program of an installed browser, if there is one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def open_page(
    browser: Browser, url: str, size: tuple[int, int], *, dark: bool = False, still: bool = False,
    offline: bool = False,
) -> None:  # fmt: skip
    """Load a page in a window of a size."""
    width, height = size
    for domain in ("Page", "Runtime", "Log", "Network"):
        browser.call(f"{domain}.enable")
    none = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    browser.call("Network.emulateNetworkConditions", offline=offline, **none)
    phone = width < 600
    browser.call(
        "Emulation.setDeviceMetricsOverride", width=width, height=height,
        deviceScaleFactor=2 if phone else 1, mobile=phone,
    )  # fmt: skip
    features = [
        {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
        {"name": "prefers-reduced-motion", "value": "reduce" if still else "no-preference"},
    ]
    browser.call("Emulation.setEmulatedMedia", features=features)
    browser.call("Page.navigate", url=url)
    browser.wait_for("Page.loadEventFired")


def inspect_page(
    program: str,
    page: Path,
    size: tuple[int, int],
    pictures: Path | None = None,
    *,
    dark: bool = False,
    still: bool = False,
) -> dict[str, Any]:
    """Open a page offline in a window of a size; return its state and its errors."""
    width = size[0]
    with Browser(program) as browser:
        open_page(browser, page.resolve().as_uri(), size, dark=dark, still=still, offline=True)
        found: dict[str, Any] = browser.evaluate(PROBE)
        if pictures is not None:
            name = f"{page.stem}_{width}{'_dark' if dark else ''}"
            browser.picture(pictures / f"{name}.png")
            tall = min(int(found["height"]), 16000 // (2 if width < 600 else 1))
            clip = {"x": 0, "y": 0, "width": width, "height": tall, "scale": 1}
            browser.picture(pictures / f"{name}_page.png", clip=clip, captureBeyondViewport=True)
        found["still"] = still
        found["errors"] = browser.errors
    return found


def faults(found: dict[str, Any]) -> list[str]:
    """Faults in the result of `inspect_page`."""
    checks = {
        "wider than the window": found["page"] > found["width"] or found["wide"],
        "errors": found["errors"],
        "asks for other files": found["requests"],
        "broken images": found["broken"],
        "no numbers": found["nan"],
        "texts of an animation overlap or are cut off": found["crowded"],
        "nothing moves": not all(found["moved"]),
        "does not play": found["plays"] is False,
        "does not obey keys": found["keys"] is False,
        "does not start by itself": found["starts"] is False and not found["still"],
        "starts by itself": found["starts"] and found["still"],
    }
    return [name for name, is_wrong in checks.items() if is_wrong]


def main() -> int:
    """Check the page named on the command line; return the exit code."""
    page = Path(sys.argv[1])
    pictures = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    program = find_browser()
    if program is None:
        sys.stderr.write(f"no browser found; looked for {', '.join(BROWSERS)}\n")
        return 2
    bad = False
    for width, height in SIZES:
        for dark in (False, True):
            found = inspect_page(program, page, (width, height), pictures, dark=dark, still=dark)
            wrong = faults(found)
            bad |= bool(wrong)
            result = f"FAILED: {', '.join(wrong)} {found}" if wrong else "ok"
            count = f"{found['images']} images, {len(found['moved'])} animations"
            sys.stdout.write(f"{width}x{height}{' dark' if dark else ''}: {count}, {result}\n")
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
