"""The page in a browser, with a pointer and keys."""

import json
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import clrt
from benchmarks import chromium
from benchmarks.chromium import PIXELS, SHIFT, Chromium, Page
from clrt.files.scenefile import parse_camera
from clrt.motion.animation import camera_at
from clrt.viewer import orbit

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium.PROGRAM is None, reason="no chromium"),
]

READY = "(b => b && !b.disabled)(document.querySelector('button[name=save]'))"
LISTEN = "document.addEventListener('picture', ({ detail }) => (window.seen ??= []).push(detail))"
MIDDLE = (200.0, 150.0)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    with Chromium(tmp_path_factory.mktemp("profile"), (480, 420)) as found:
        yield found


@pytest.fixture(scope="module")
def address() -> Iterator[Callable[[str], str]]:
    """Of a view of a scene, which runs until all tests are done."""
    running: dict[str, tuple[subprocess.Popen[str], str]] = {}

    def of(scene: str) -> str:
        if scene not in running:
            command = [sys.executable, "-m", "clrt", "view", scene]
            process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            assert process.stdout is not None
            running[scene] = process, process.stdout.readline().strip()
        return running[scene][1]

    yield of
    for process, _ in running.values():
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
        assert process.returncode == 130
        assert said == "Ctrl-C ends it\nclrt: interrupted\n"  # and nothing of what pages did


@pytest.fixture
def show(browser: Chromium, address: Callable[[str], str]) -> Iterator[Callable[..., Page]]:
    pages: list[Page] = []

    def show(scene: str = "four-spheres") -> Page:
        page = browser.open(address(scene))
        pages.append(page)
        page.wait(READY)
        page.value(LISTEN)
        return page

    yield show
    for page in pages:
        page.close()


def command(page: Page) -> list[str]:
    """What "Copy as command" shows."""
    page.wait(READY)
    page.value("document.querySelector('button[name=command]').click()")
    words = shlex.split(page.value("document.querySelector('pre').textContent"))
    assert words[:2] == ["clrt", "render"]
    return words[1:]


def camera(page: Page) -> clrt.Camera:
    return parse_camera(command(page)[-1])


def size(page: Page) -> tuple[int, int]:
    width, height = page.value(
        "(c => [c.clientWidth, c.clientHeight])(document.querySelector('canvas'))"
    )
    return width, height


def on_canvas(page: Page) -> np.ndarray:
    """What is drawn on it: (height, width, 4)."""
    width, height, pixels = page.value(PIXELS + "(document.querySelector('canvas'))")
    return np.array(pixels, np.uint8).reshape(height, width, 4)


def test_the_last_picture_is_that_of_the_command(show: Callable[..., Page], tmp_path: Path) -> None:
    """Pixel by pixel: on the canvas, on the screen, and in the file that is saved."""
    page = show()
    page.drag(MIDDLE, (230, 160), (260, 140))
    page.wait(f"window.seen?.length && {READY}")
    words = [sys.executable, "-m", "clrt", *command(page), "-o", "a.png"]
    subprocess.run(words, cwd=tmp_path, check=True)
    expected = np.asarray(Image.open(tmp_path / "a.png"))
    assert (on_canvas(page)[..., :3] == expected).all()
    page.value("document.querySelector('pre').hidden = true")
    page.value("document.querySelector('[role=status]').value = ''")
    page.value("document.activeElement.blur()")
    height, width, _ = expected.shape
    assert (page.screenshot()[:height, :width] == expected).all()
    page.do("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    page.value("document.querySelector('button[name=save]').click()")
    saved = tmp_path / "four-spheres.png"
    for _ in range(200):
        if saved.exists():
            break
        page.value("new Promise(done => setTimeout(done, 20))")
    assert saved.read_bytes() == (tmp_path / "a.png").read_bytes()


def test_pictures_move_with_the_pointer(show: Callable[..., Page]) -> None:
    page = show()
    before = page.screenshot()
    left: dict[str, Any] = {"button": "left", "buttons": 1}
    page.mouse("Pressed", *MIDDLE, clickCount=1, **left)
    for x in range(210, 300, 10):
        page.mouse("Moved", x, 150, **left)
    page.wait("window.seen?.some(({ moves }) => moves)")
    assert (page.screenshot() != before).any()
    page.mouse("Released", 300, 150, clickCount=1, **left)
    page.wait(READY)
    kinds = [(each["moves"], each["final"]) for each in page.value("window.seen")]
    assert kinds[0] == (True, False)
    assert kinds[-1] == (False, True)


def test_pointer_and_keys(show: Callable[..., Page]) -> None:
    """Each does what the move of its name does."""
    page = show()
    start, (width, height) = clrt.load_scene("four-spheres").camera, size(page)
    assert camera(page) == start
    page.drag(MIDDLE, (240, 150), (240, 165))
    degrees = 180 / height
    # By and by: floats differ in the last place.
    expected = orbit.turned(orbit.turned(start, -40 * degrees, 0), 0, 15 * degrees)
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)
    page.key("r")
    assert camera(page) == start
    page.drag(MIDDLE, (170, 190), modifiers=SHIFT)
    expected = orbit.panned(start, -30, 40, (width, height))
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)
    page.key("r")
    page.mouse("Wheel", 100, 50, deltaX=0, deltaY=-120)
    expected = orbit.zoomed(start, np.exp(120 / 500), (99.5, 49.5), (width, height))
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)
    page.key("r")
    page.value("document.querySelector('canvas').focus()")
    page.key("ArrowRight")
    assert camera(page) == orbit.turned(start, -180 / 36, 0)
    page.key("ArrowRight", SHIFT)
    assert camera(page).look_at != start.look_at
    page.key("r")
    page.key("o")
    assert camera(page) == orbit.orthographic(start, (width, height))
    page.key("o")
    page.key("+")
    expected = orbit.zoomed(start, 1.1, (width / 2 - 0.5, height / 2 - 0.5), (width, height))
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)


def test_pick(show: Callable[..., Page]) -> None:
    page = show()
    width, height = size(page)
    truth = clrt.reference.trace(clrt.load_scene("four-spheres"), width, height, truth="exact")
    scene = clrt.load_scene("four-spheres")
    for x, y in [(150, 130), (250, 140), (470, 250)]:
        page.value("document.querySelector('[role=status]').value = ''")
        page.drag((x, y), (x + 1, y))  # a hand is not quite still
        index = truth.id[y, x]
        words = page.wait("document.querySelector('[role=status]').value")
        assert words.startswith(f"index {index}, position (")
        assert words.endswith(f"material {scene.spheres[index].material}")
    page.mouse("Moved", 1, 1)
    page.drag((240, 2), (240, 2))
    page.wait("document.querySelector('[role=status]').value === 'nothing there'")
    page.value("document.querySelector('canvas').focus()")
    page.key("Enter")
    page.wait("document.querySelector('[role=status]').value.startsWith('index')")


def test_samples(show: Callable[..., Page]) -> None:
    page = show()
    page.value(
        "(s => { s.value = 16; s.dispatchEvent(new Event('change')) })"
        "(document.querySelector('select'))"
    )
    page.wait(READY)
    seen = [each["samples"] for each in page.value("window.seen") if not each["moves"]]
    assert seen == [1, 4, 16]
    assert page.value("document.querySelector('[role=status]').value") == "16 of 16 samples"
    words = command(page)
    assert words[words.index("--samples") + 1] == "16"
    page.value("document.querySelector('button[name=toml]').click()")
    assert page.value("document.querySelector('pre').textContent").startswith("samples = 16\n")


def test_style(show: Callable[..., Page], tmp_path: Path) -> None:
    (tmp_path / "water.xyz").write_text("3\n\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n")
    page = show(str(tmp_path / "water.xyz"))
    assert page.value("document.querySelector('select[name=style]').value") == "soft"
    before = on_canvas(page)
    page.value(
        "(s => { s.value = 'outline'; s.dispatchEvent(new Event('change')); })"
        "(document.querySelector('select[name=style]'))"
    )
    words = command(page)
    assert words[words.index("--style") + 1] == "outline"
    assert (on_canvas(page) != before).any()


def test_time(show: Callable[..., Page]) -> None:
    page = show("orbit")
    assert page.value("document.querySelector('[name=frame]').max") == "119"
    page.value(
        "(s => { s.value = 30; s.dispatchEvent(new Event('input')) })"
        "(document.querySelector('[name=frame]'))"
    )
    assert camera(page) == camera_at(clrt.load_scene("orbit"), 30)
    page.value("document.querySelector('[name=play]').click()")
    page.wait("new Set(window.seen.map(({ frame }) => frame)).size > 8")
    page.value("document.querySelector('[name=play]').click()")
    page.wait(READY)
    frames = [each["frame"] for each in page.value("window.seen")]
    assert frames[0] == 30
    assert frames[1:] == sorted(frames[1:])  # it has not come round
    at = int(page.value("document.querySelector('[name=at]').value"))
    assert camera(page) == camera_at(clrt.load_scene("orbit"), at)


def test_two_pages_at_once(show: Callable[..., Page]) -> None:
    one, other = show(), show()
    other.value("document.querySelector('[name=projection]').click()")
    assert not camera(one).orthographic
    assert camera(other).orthographic
    other.do("Page.navigate", url="about:blank")
    one.value("document.querySelector('[name=reset]').click()")
    assert camera(one) == clrt.load_scene("four-spheres").camera


def test_a_page_from_elsewhere_cannot_connect(
    browser: Chromium, address: Callable[[str], str]
) -> None:
    """Even if it knew the token."""
    page = browser.open("data:text/html,elsewhere")
    socket = json.dumps(address("four-spheres").replace("http", "ws").replace("/?", "/ws?"))
    found = page.value(
        f"new Promise(done => {{ const socket = new WebSocket({socket});"
        "socket.onopen = () => done('open'); socket.onerror = () => done('refused'); })"
    )
    assert found == "refused"
    page.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark(show: Callable[..., Page], scheme: str) -> None:
    page = show()
    features: list[dict[str, Any]] = [{"name": "prefers-color-scheme", "value": scheme}]
    page.do("Emulation.setEmulatedMedia", features=features)
    corner = page.screenshot()[-3:, -3:].mean()
    assert corner > 200 if scheme == "light" else corner < 60


def test_every_control_has_a_name(show: Callable[..., Page]) -> None:
    """As a screen reader tells it."""
    page = show("orbit")
    page.do("Accessibility.enable")
    nodes = page.do("Accessibility.getFullAXTree")["nodes"]
    roles = {"button", "combobox", "slider", "application"}
    names = [n["name"]["value"] for n in nodes if n["role"]["value"] in roles]
    assert len(names) >= 9
    assert all(names)
