"""Chromium without a window, driven by its DevTools protocol: Debian's `chromium`."""

import base64
import io
import itertools
import json
import re
import resource
import shutil
import subprocess
import time
import urllib.request
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from websockets.sync.client import connect

NO_LIMIT = resource.getrlimit(resource.RLIMIT_AS)[0] == resource.RLIM_INFINITY
PROGRAM = shutil.which("chromium") if NO_LIMIT else None
"""It takes far more addresses than memory, and does not start where these are few."""
CONTROL, SHIFT = 2, 8  # of DevTools' modifiers
KEYS = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Enter": 13}

# What a canvas shows: a function that returns its width and height on the screen, and its pixels.
PIXELS = """((canvas) => {
  const { left, right, top, bottom } = canvas.getBoundingClientRect();
  const width = Math.round(right) - Math.round(left), height = Math.round(bottom) - Math.round(top);
  const context = new OffscreenCanvas(width, height).getContext("2d");
  context.drawImage(canvas, 0, 0, width, height);
  return [width, height, Array.from(context.getImageData(0, 0, width, height).data)];
})"""


class Page:
    """A tab. Positions are in CSS pixels from its upper left corner."""

    def __init__(self, address: str) -> None:
        self._open = ExitStack()
        self._socket = self._open.enter_context(connect(address, max_size=None))
        self._numbers = itertools.count()
        self.do("Page.enable")
        self.do("Runtime.enable")

    def do(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while (answer := json.loads(self._socket.recv(timeout=60))).get("id") != number:
            pass
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    def value(self, expression: str) -> Any:
        """What JavaScript says, or what it promises."""
        found = self.do(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait(self, expression: str, seconds: float = 30) -> Any:
        """The value as soon as it is true."""
        end = time.monotonic() + seconds
        while not (found := self.value(expression)):
            assert time.monotonic() < end, f"{expression} is not true after {seconds} s"
            time.sleep(0.02)
        return found

    def resize(self, width: int, height: int) -> None:
        """To so many pixels of the screen."""
        size = {"width": width, "height": height}
        self.do("Emulation.setDeviceMetricsOverride", **size, deviceScaleFactor=1, mobile=False)

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """kind: Pressed, Released, Moved or Wheel."""
        self.do("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, **more)

    def drag(self, *places: tuple[float, float], modifiers: int = 0) -> None:
        """Down at the first place, over the others, and up at the last."""
        left: dict[str, Any] = {"button": "left", "buttons": 1, "modifiers": modifiers}
        self.mouse("Pressed", *places[0], clickCount=1, **left)
        for place in places[1:]:
            self.mouse("Moved", *place, **left)
        self.mouse("Released", *places[-1], clickCount=1, **left)

    def touch(self, kind: str, *places: tuple[float, float]) -> None:
        """kind: Start, Move or End: where all fingers are then."""
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
        self.do("Input.dispatchTouchEvent", type=f"touch{kind}", touchPoints=points)

    def key(self, key: str, modifiers: int = 0) -> None:
        code = KEYS.get(key, ord(key[0].upper()))
        given = {"key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers}
        text = {"text": key} if len(key) == 1 else {}
        self.do("Input.dispatchKeyEvent", type="keyDown", **given, **text)
        self.do("Input.dispatchKeyEvent", type="keyUp", **given)

    def screenshot(self) -> NDArray[np.uint8]:
        """(height, width, 3)."""
        data = base64.b64decode(self.do("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    def close(self) -> None:
        self.do("Page.close")
        self._open.close()


class Chromium:
    """A browser, as long as a `with` lasts."""

    def __init__(self, profile: Path, size: tuple[int, int] = (800, 600)) -> None:
        assert PROGRAM is not None
        self._process = subprocess.Popen(
            [
                *(PROGRAM, "--headless=new", "--no-sandbox", "--disable-gpu"),
                *("--remote-debugging-port=0", f"--user-data-dir={profile}"),
                *("--no-first-run", "--hide-scrollbars", "--disable-dev-shm-usage"),
                f"--window-size={size[0]},{size[1]}",
                "about:blank",
            ],
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self._process.stderr is not None
        for line in self._process.stderr:
            if found := re.search(r"DevTools listening on ws://([^/]+)/", line):
                self._host = found[1]
                break

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._process.terminate()
        self._process.communicate(timeout=30)

    def open(self, address: str) -> Page:
        """A tab in front."""
        request = urllib.request.Request(f"http://{self._host}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=30) as answer:
            page = Page(json.load(answer)["webSocketDebuggerUrl"])
        page.do("Page.navigate", url=address)
        return page
