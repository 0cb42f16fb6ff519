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
from benchmarks.chromium import CONTROL, PIXELS, SHIFT, Chromium, Page
from clrt.files.scenefile import parse_camera
from clrt.motion.animation import camera_at
from clrt.viewer import orbit
from clrt.viewer.subject import of_file

pytestmark = pytest.mark.skipif(chromium.PROGRAM is None, reason="no chromium")

READY = "(b => b && !b.disabled)(document.querySelector('button[name=save]'))"
LISTEN = "document.addEventListener('picture', ({ detail }) => (window.seen ??= []).push(detail))"
MIDDLE = (200.0, 150.0)
ROW = (
    "(table => table.hidden ? null : [...table.rows].map(row => "
    "[...row.cells].map(cell => cell.textContent).join(' ')))(document.querySelector('table'))"
)
OVER = "(document.querySelector('.over'))"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    with Chromium(tmp_path_factory.mktemp("profile"), (600, 560)) as found:
        yield found


@pytest.fixture(scope="module")
def address() -> Iterator[Callable[..., str]]:
    """Of a view of a scene, which runs until all tests are done."""
    running: dict[tuple[str, ...], tuple[subprocess.Popen[str], str]] = {}

    def of(*scene: str) -> str:
        if scene not in running:
            command = [sys.executable, "-m", "clrt", "view", *scene]
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
def show(browser: Chromium, address: Callable[..., str]) -> Iterator[Callable[..., Page]]:
    pages: list[Page] = []

    def show(scene: str = "four-spheres", *options: str) -> Page:
        page = browser.open(address(scene, *options))
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


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
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
    expected = orbit.turned(start, -180 / 36, 0)
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)
    page.key("ArrowRight", SHIFT)
    assert camera(page).look_at != start.look_at
    page.key("r")
    page.key("o")
    assert camera(page) == orbit.orthographic(start, (width, height))
    page.key("o")
    page.key("+")
    expected = orbit.zoomed(start, 1.1, (width / 2 - 0.5, height / 2 - 0.5), (width, height))
    assert camera(page).position == pytest.approx(expected.position, abs=1e-12)


@pytest.mark.slow
def test_pick(show: Callable[..., Page]) -> None:
    page = show()
    width, height = size(page)
    truth = clrt.reference.trace(clrt.load_scene("four-spheres"), width, height, truth="exact")
    scene = clrt.load_scene("four-spheres")
    for index in (1, 2, 0):
        rows, columns = np.nonzero(truth.id == index)
        y, x = int(rows[len(rows) // 2]), int(columns[len(rows) // 2])
        page.drag((x, y), (x + 1, y))  # a hand is not quite still
        page.wait(f"{ROW}?.[0] === 'index {index}'")
        position, *_, material = page.value(ROW)[1:]
        assert position.startswith("position (")
        assert material == f"material {scene.spheres[index].material}"
    page.mouse("Moved", 1, 1)
    page.drag((240, 2), (240, 2))
    page.wait("document.querySelector('[role=status]').value === 'nothing there'")
    assert page.value(ROW) is None
    page.value("document.querySelector('canvas').focus()")
    page.key("Enter")
    page.wait(f"!!{ROW}")


@pytest.mark.slow
def test_samples(show: Callable[..., Page]) -> None:
    page = show()
    page.value(
        "(s => { s.value = 16; s.dispatchEvent(new Event('change')) })"
        "(document.querySelector('select[name=samples]'))"
    )
    page.wait(READY)
    seen = [each["samples"] for each in page.value("window.seen") if not each["moves"]]
    assert seen == [1, 4, 16]
    assert page.value("document.querySelector('[role=status]').value") == "16 of 16 samples"
    words = command(page)
    assert words[words.index("--samples") + 1] == "16"
    page.value("document.querySelector('button[name=toml]').click()")
    assert page.value("document.querySelector('pre').textContent").startswith("samples = 16\n")


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_two_pages_at_once(show: Callable[..., Page]) -> None:
    one, other = show(), show()
    other.value("document.querySelector('[name=projection]').click()")
    assert not camera(one).orthographic
    assert camera(other).orthographic
    other.do("Page.navigate", url="about:blank")
    one.value("document.querySelector('[name=reset]').click()")
    assert camera(one) == clrt.load_scene("four-spheres").camera


@pytest.mark.slow
def test_a_page_from_elsewhere_cannot_connect(
    browser: Chromium, address: Callable[..., str]
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


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_light_and_dark(show: Callable[..., Page], scheme: str) -> None:
    page = show()
    features: list[dict[str, Any]] = [{"name": "prefers-color-scheme", "value": scheme}]
    page.do("Emulation.setEmulatedMedia", features=features)
    corner = page.screenshot()[-3:, -3:].mean()
    assert corner > 200 if scheme == "light" else corner < 60


@pytest.mark.slow
def test_every_control_has_a_name(show: Callable[..., Page]) -> None:
    """As a screen reader tells it."""
    page = show("orbit")
    page.do("Accessibility.enable")
    nodes = page.do("Accessibility.getFullAXTree")["nodes"]
    roles = {"button", "combobox", "slider", "application"}
    names = [n["name"]["value"] for n in nodes if n["role"]["value"] in roles]
    assert len(names) >= 9
    assert all(names)


KEYS_PASS = (
    "document.addEventListener('keydown', ({ key }) => (window.heard ??= []).push(key), true)"
)


def test_a_focused_canvas_keeps_plain_keys(show: Callable[..., Page]) -> None:
    """Of which a notebook would delete cells, even those that it does not know; not the others."""
    page = show()
    page.value(KEYS_PASS)
    page.value("document.querySelector('canvas').focus()")
    for key in "abdmqvu":
        page.key(key)
    page.value("document.querySelector('[name=reset]').focus()")
    page.key("d")
    page.key("k", CONTROL)
    assert page.value("window.heard") == ["k"]
    page.value("document.activeElement.blur()")
    page.key("d")
    assert page.value("window.heard") == ["k", "d"]


def test_fingers(show: Callable[..., Page]) -> None:
    """One turns, two pan and zoom, a tap picks."""
    page = show()
    page.do("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    page.wait("window.seen?.at(-1).final")  # the buttons are larger
    start, (width, height) = clrt.load_scene("four-spheres").camera, size(page)
    page.touch("Start", (width / 2, height / 2))
    page.touch("End")
    page.wait(f"!!{ROW}")
    page.touch("Start", (450, 300))
    page.touch("Move", (490, 300))
    page.touch("End")
    turned = orbit.turned(start, -180 / height * 40, 0)
    assert camera(page).position == pytest.approx(turned.position, abs=1e-12)
    page.value("document.querySelector('[name=reset]').click()")
    page.touch("Start", (300, 200))
    page.touch("Start", (300, 200), (400, 200))
    page.touch("Move", (300, 200), (500, 200))
    page.touch("Move", (320, 230), (520, 230))
    page.touch("End")
    expected = orbit.panned(start, 50, 0, (width, height))
    expected = orbit.zoomed(expected, 2, (399.5, 199.5), (width, height))
    expected = orbit.panned(expected, 20, 30, (width, height))
    found = camera(page)
    assert found.position == pytest.approx(expected.position, abs=0.02)
    assert found.look_at == pytest.approx(expected.look_at, abs=0.02)


def test_windows_of_any_shape(show: Callable[..., Page]) -> None:
    """All is in view, until somebody moves; a small one has its controls behind a button."""
    page = show()
    start = clrt.load_scene("four-spheres").camera
    try:
        for wide, high in ((320, 240), (700, 200), (300, 700)):
            page.resize(wide, high)
            page.wait(f"window.seen?.at(-1).size[0] === {wide} && window.seen.at(-1).final")
            assert camera(page) == orbit.held(start, (16, 9), size(page))
        page.resize(320, 240)
        page.wait("window.seen.at(-1).size[1] > 200 && window.seen.at(-1).final")
        assert not page.value("document.querySelector('[name=reset]').checkVisibility()")
        page.value("document.querySelector('[name=menu]').click()")
        assert page.value("document.querySelector('[name=reset]').checkVisibility()")
        page.value("document.querySelector('.help').open = true")
        seen = "(list => (list.scrollIntoView(), list.contains(document.elementFromPoint("
        middle = "list.getBoundingClientRect().x + 9, list.getBoundingClientRect().y + 9))))"
        assert page.value(f"{seen}{middle}(document.querySelector('dl'))")
        page.value("document.querySelector('.help').open = false")
        page.drag((100, 60), (120, 60))
        moved = camera(page)
        page.resize(700, 200)
        page.wait("window.seen.at(-1).size[0] === 700 && window.seen.at(-1).final")
        assert camera(page) == moved
    finally:
        page.do("Emulation.clearDeviceMetricsOverride")


@pytest.fixture
def gas(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.getbasetemp() / "gas.extxyz"
    lines = []
    for shift in (0.0, 0.5):
        lines += ["8", 'Lattice="4 0 0 0 4 0 0 0 4" Properties=species:S:1:pos:R:3:speed:R:1']
        lines += [
            f"O {1 + 2 * (k & 1) + shift} {1 + (k & 2)} {1 + (k >> 2) * 2} {k}" for k in range(8)
        ]
    path.write_text("\n".join(lines) + "\n")
    return path


FIELD = (
    "(([name, value]) => { const field = document.querySelector(`[name=${name}]`);"
    "field.value = value; field.dispatchEvent(new Event('change')); })"
)


@pytest.mark.slow
def test_what_is_over_the_picture_stays_sharp(show: Callable[..., Page], gas: Path) -> None:
    """Bar and words are the same while the picture moves, and at rest; lines are over it."""
    options = ["--color", "speed", "--colorbar", "speed", "--cell", "--samples", "64"]
    page = show(str(gas), *options, "--cmap", "coolwarm")
    bar = np.s_[:, -40:]
    rest = on_canvas(page)[bar]
    assert page.value(OVER + ".hidden")
    left: dict[str, Any] = {"button": "left", "buttons": 1}
    page.mouse("Pressed", *MIDDLE, clickCount=1, **left)
    page.value("window.seen = []")
    page.mouse("Moved", 240, 150, **left)
    page.wait("window.seen.some(({ moves }) => moves)")
    width, height, pixels = page.value(PIXELS + OVER)
    over = np.array(pixels, np.uint8).reshape(height, width, 4)
    assert (over[bar][..., 3] == 255).all()
    assert abs(over[bar].astype(int) - rest)[..., :3].max() <= 1
    lines = (over[:, :-100, 3] > 0).mean()
    assert 0.002 < lines < 0.1
    page.mouse("Released", 240, 150, clickCount=1, **left)
    page.wait(READY)
    assert (on_canvas(page)[bar] == rest).all()


@pytest.mark.slow
def test_pick_marks(show: Callable[..., Page], gas: Path) -> None:
    """Its row is shown, a ring goes with it, and it goes into the command; a second click looks at
    it."""
    page = show(str(gas), "--radius", "0.8", "--bonds", "2.1", "--bond-radius", "0.3")
    page.value("document.querySelector('canvas').focus()")
    page.key("z")
    page.wait(READY)
    around = orbit.circle(camera(page), (3.0, 3.0, 3.0), 1.0, size(page))
    assert around is not None
    column, row, unit = around
    place = column + unit / 2, row + unit / 2  # beside the bond towards the camera
    page.drag((5, 5), (5, 5))  # puts away what was copied
    page.drag(place, place)
    page.wait(f"{ROW}?.[0] === 'index 7'")
    assert "speed 7" in page.value(ROW)
    width, height, pixels = page.value(PIXELS + OVER)
    ring = np.array(pixels, np.uint8).reshape(height, width, 4)[..., 3]
    assert ring[round(row)].any()
    words = command(page)
    assert words[words.index("--center") + 1] == "3.0,3.0,3.0"
    page.value("new Promise(done => setTimeout(done, 500))")
    for _ in "12":
        page.drag(place, place)
    page.wait("window.seen.at(-1).final && Math.abs(window.seen.at(-1).mark?.[0][0] * 2 - "
              "window.seen.at(-1).size[0]) < 2")  # fmt: skip
    assert camera(page).look_at == pytest.approx((3, 3, 3))
    # A bond has a mark of its own shape.
    around = orbit.circle(camera(page), (2.0, 3.0, 3.0), 0.3, size(page))
    assert around is not None
    column, row, _ = around
    page.drag((5, 5), (5, 5))
    page.drag((column, row), (column, row))
    page.wait("document.querySelector('[role=status]').value.startsWith('bond ')")
    assert any(each.startswith("start ") for each in page.value(ROW))
    width, height, pixels = page.value(PIXELS + OVER)
    drawn = np.array(pixels, np.uint8).reshape(height, width, 4)[..., 3]
    rows, columns = np.nonzero(drawn)
    assert np.ptp(columns) > 2 * np.ptp(rows)
    assert not drawn[round(row), round(column)]
    words = command(page)
    assert words[words.index("--center") + 1] == "2.0,3.0,3.0"


@pytest.mark.slow
def test_looks(show: Callable[..., Page], gas: Path) -> None:
    page = show(str(gas))
    for name, value, option in (
        ("color", "speed", ["--color", "speed"]),
        ("cmap", "turbo", ["--cmap", "turbo"]),
        ("clim", "1 5", ["--clim", "1.0", "5.0"]),
        ("select", "x > 2", ["--select", "x > 2"]),
        ("opacity", "0.2 + 0.1 * (z > 2)", ["--opacity", "0.2 + 0.1 * (z > 2)"]),
    ):
        before = on_canvas(page)
        page.value(f"{FIELD}({json.dumps([name, value])})")
        words = command(page)
        at = words.index(option[0])
        assert words[at : at + len(option)] == option
        assert (on_canvas(page) != before).any(), name
    page.value(f"{FIELD}(['select', 'x >'])")
    said = page.wait("document.querySelector('[name=wrong]').value")
    assert "select: " in said
    assert "x > 2" in command(page)
    page.value(f"{FIELD}(['opacity', '2'])")
    said = page.wait("document.querySelector('[name=wrong]').value")
    assert "opacity: " in said
    page.value(f"{FIELD}(['select', ''])")
    assert "--select" not in command(page)
    assert page.value("document.querySelector('[name=wrong]').value") == ""


@pytest.mark.slow
def test_sides_and_steps(show: Callable[..., Page], gas: Path) -> None:
    page, subject = show(str(gas)), of_file(gas, {})
    page.value("document.querySelector('canvas').focus()")
    for key, view in (("y", "y"), ("X", "-x"), ("i", "iso")):
        page.key(key)
        assert camera(page) == subject.framed(subject.at(0), size(page), view)
    page.value(
        "[...document.querySelectorAll('.sides button')].find(b => b.textContent === 'z').click()"
    )
    assert camera(page) == subject.framed(subject.at(0), size(page), "z")
    page.value("document.querySelector('canvas').focus()")
    page.key(".")
    assert command(page)[-4:-2] != ["--frame", "0"]
    assert page.value("document.querySelector('[name=at]').value") == "1"
    page.value("document.querySelector('[name=on]').click()")
    page.wait("document.querySelector('[name=at]').value === '0'")
    page.key("h")
    assert page.value("document.querySelector('.help').open")
    page.key("Escape")
    assert not page.value("document.querySelector('.help').open")
    for there in ("true", "false"):
        page.key("f")
        page.wait(f"{there} === !!document.fullscreenElement?.querySelector('canvas')")


@pytest.mark.slow
def test_buttons_for_fingers(show: Callable[..., Page]) -> None:
    page = show()
    page.do("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
    high = page.value(
        "[...document.querySelectorAll('form > :is(button, select)')]"
        ".filter(b => b.checkVisibility()).map(b => b.offsetHeight)"
    )
    assert len(high) > 3
    assert min(high) >= 40
