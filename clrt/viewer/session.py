"""Session: one viewer's sight of a subject, and the messages that change it."""

import json
import shlex
from collections.abc import Iterator
from contextlib import suppress
from typing import Annotated, Any, Literal, TypeAlias

import msgspec
import numpy as np
from msgspec import Meta, Struct
from msgspec.structs import replace

from clrt.errors import SceneError
from clrt.figure.styles import STYLES
from clrt.particles.palette import COLORMAPS
from clrt.scene.camera import Camera
from clrt.scene.film import Film
from clrt.scene.scene import MAX_SAMPLES, Scene
from clrt.viewer import orbit
from clrt.viewer.subject import Subject
from clrt.viewer.thing import Ring, thing

FOV = 40.0
"""Degrees, of a perspective camera in place of an orthographic one."""
TURN = 180.0
"""Degrees that a drag over the height of the picture turns."""

Length: TypeAlias = Annotated[int, Meta(ge=1, le=8192)]
Side: TypeAlias = Literal["corner", "iso", "x", "-x", "y", "-y", "z", "-z"]
"""One of clrt.figure.framing.VIEWS."""
Pixels: TypeAlias = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Message(Struct, tag=str.lower, tag_field="do", forbid_unknown_fields=True):
    """A message of a page. Lengths are in pixels of the whole picture, x to the right, y down, from
    the middle of the first one."""


class Resize(Message):
    width: Length
    height: Length


class Turn(Message):
    x: Pixels
    y: Pixels


class Pan(Message):
    x: Pixels
    y: Pixels


class Zoom(Message):
    factor: Annotated[float, Meta(ge=0.01, le=100)]
    x: Pixels
    y: Pixels


class Reset(Message):
    pass


class Project(Message):
    projection: Literal["perspective", "orthographic"]


class Sample(Message):
    samples: Annotated[int, Meta(ge=1, le=MAX_SAMPLES)]


class View(Message):
    """From a side, so that all is in view."""

    view: Side


class Look(Message):
    """Another look of particles, as an option says it."""

    key: Literal["style", "color", "cmap", "clim", "select", "opacity"]
    value: Annotated[str, Meta(max_length=500)]


class Center(Message):
    """What was picked last goes to the middle."""


class Frame(Message):
    frame: Annotated[int, Meta(ge=0)]


class Pick(Message):
    """What is at a pixel is marked, or if there is nothing nothing."""

    x: Annotated[int, Meta(ge=0)]
    y: Annotated[int, Meta(ge=0)]


class Shown(Message):
    """A picture was drawn: another one can come."""

    number: int


Change: TypeAlias = (
    Resize | Turn | Pan | Zoom | Reset | View | Center | Project | Sample | Look | Frame
)
MESSAGES: msgspec.json.Decoder[Change | Pick | Shown] = msgspec.json.Decoder(Change | Pick | Shown)
"""Raises msgspec.DecodeError: it is none."""


class Shot(Struct, frozen=True):
    """All that a picture depends on, and how the command line says so."""

    subject: Subject
    frame: int
    scene: Scene
    size: orbit.Size
    marked: int = -1
    """The index of a thing, or -1."""

    @property
    def mark(self) -> list[Ring] | None:
        """Where the thing that is marked is."""
        found = thing(self.scene, self.marked)
        return None if found is None else found.rings(self.scene.camera, self.size)

    @property
    def name(self) -> str:
        """Of the thing that is marked."""
        found = thing(self.scene, self.marked)
        if found is None:
            return ""
        kind = self.subject.capsules if found.kind == "capsule" else found.kind
        return f"{kind} {found.number}"

    @property
    def command(self) -> str:
        """The command that makes this picture, but for its file's name; "" if there is none."""
        if not self.subject.words:
            return ""
        width, height = map(str, self.size)
        words = ["clrt", "render", *self.subject.words, "--width", width, "--height", height]
        words += ["--samples", str(self.scene.samples)]
        if self.subject.is_trajectory:
            words += ["--frame", str(self.frame)]
        # Whoever leaves the camera out has in the middle what is marked.
        marked = thing(self.scene, self.marked)
        if self.subject.is_figure and marked is not None:
            words += ["--center", ",".join(map(repr, marked.middle))]
        return shlex.join([*words, "--camera", ", ".join(_toml(self.scene.camera))])

    @property
    def toml(self) -> str:
        """The lines of a scene file that give this view."""
        lines = [f"samples = {self.scene.samples}", "", "[camera]", *_toml(self.scene.camera)]
        return "\n".join(lines) + "\n"


def _toml(camera: Camera) -> Iterator[str]:
    """Keys and values, each a line. JSON's form of these values is TOML as well."""
    for field in msgspec.structs.fields(camera):
        value = getattr(camera, field.name)
        if value is not None and value != field.default:
            yield f"{field.name} = {json.dumps(value)}"


class Session:
    """Where somebody has moved to."""

    def __init__(self, subject: Subject, samples: int | None = None) -> None:
        """samples: default: the scene's."""
        self.subject = subject
        self._frame = 0
        self._size: orbit.Size | None = None
        self.scene = subject.at(0)
        """The scene in view, with as many samples as it gets at rest."""
        self._first = samples or self.scene.samples
        self._view: str | None = None
        self._is_moved = False  # by hand
        self.marked = -1
        """The index of the thing that is marked, or -1."""
        self._reset()

    def _reset(self) -> None:
        self.scene = replace(self.subject.at(self._frame), samples=self._first)
        self._view = None
        self._frame_it()

    def _frame_it(self) -> None:
        """Gives the scene the camera that holds all of it in a picture of this size."""
        self._is_moved = False
        if self._size is not None:
            whole = self.subject.at(self._frame)
            camera = self.subject.framed(whole, self._size, self._view)
            self.scene = self._through(camera, self.scene, whole.film)

    @property
    def shot(self) -> Shot | None:
        """The picture that is due; None as long as nobody has said how large it is."""
        if self._size is None:
            return None
        return Shot(self.subject, self._frame, self.scene, self._size, self.marked)

    @property
    def about(self) -> dict[str, Any]:
        """The first message to a page."""
        subject = self.subject
        return {
            "name": subject.words[0] if subject.words else "picture",
            "spheres": len(self.scene.spheres),
            f"{subject.capsules}s": len(self.scene.capsules),
            "faces": sum(map(len, self.scene.meshes)),
            "frames": subject.frames,
            "fps": subject.fps,
            "styles": list(STYLES) if subject.drawn else [],
            "cmaps": COLORMAPS,
            "columns": subject.columns,
        }

    @property
    def state(self) -> dict[str, Any]:
        """The text and values that a page shows beside the picture."""
        camera = self.scene.camera
        return {
            "frame": self._frame,
            "projection": camera.projection,
            "most": self.scene.samples,
            "look": dict(self.subject.look),
            "mark": None if (shot := self.shot) is None else shot.mark,
        }

    def change(self, message: Change) -> None:
        """Obeys a message. A camera that cannot be leaves the present one.

        Raises:
            ClrtError: a frame cannot be read.
        """
        if isinstance(message, Resize):
            self._size = message.width, message.height
            if not self._is_moved:
                self._frame_it()
        elif isinstance(message, Reset):
            self._reset()
        elif isinstance(message, Sample):
            self.scene = replace(self.scene, samples=message.samples)
        elif isinstance(message, Look):
            if self.subject.drawn:
                self.subject = self.subject.drawn(message.key, message.value)
                self.marked = -1  # others may be there
                self._look_at(self._frame, stays=True)
        elif isinstance(message, View):
            self._view = message.view
            self._frame_it()
        elif isinstance(message, Frame):
            frame = min(message.frame, self.subject.frames - 1)
            self._look_at(frame, stays=self.subject.is_trajectory)
        elif self._size is not None:
            with suppress(SceneError), np.errstate(all="ignore"):
                camera = self._moved(self.scene.camera, message, self._size)
                film = self.subject.at(self._frame).film
                self.scene = self._through(camera, self.scene, film)
                self._is_moved = True

    def _through(self, camera: Camera, scene: Scene, film: Film) -> Scene:
        """A scene with another camera, and the film of its subject: with a scale bar as long as
        that camera has one."""
        if film.scalebar is None:
            return self.subject.seen_by(scene, camera)
        bare = replace(scene, film=replace(film, scalebar=None))
        seen = self.subject.seen_by(bare, camera)
        return replace(seen, film=film) if camera.orthographic else seen

    def _look_at(self, frame: int, stays: bool) -> None:
        """stays: the camera does."""
        scene = self.subject.at(frame)
        if stays:
            scene = self._through(self.scene.camera, scene, scene.film)
        self._frame, self.scene = frame, replace(scene, samples=self.scene.samples)
        if not stays:
            self._frame_it()

    def _moved(
        self, camera: Camera, message: Turn | Pan | Zoom | Center | Project, size: orbit.Size
    ) -> Camera:
        """Raises SceneError: no camera can be there."""
        if isinstance(message, Turn):
            degrees = TURN / size[1]
            return orbit.turned(camera, -degrees * message.x, degrees * message.y)
        if isinstance(message, Pan):
            return orbit.panned(camera, message.x, message.y, size)
        if isinstance(message, Zoom):
            return orbit.zoomed(camera, message.factor, (message.x, message.y), size)
        if isinstance(message, Center):
            marked = thing(self.scene, self.marked)
            return camera if marked is None else orbit.towards(camera, marked.middle)
        if message.projection == "orthographic":
            return orbit.orthographic(camera, size)
        fov = self.subject.at(self._frame).camera.fov or FOV
        return orbit.perspective(camera, fov, size)
