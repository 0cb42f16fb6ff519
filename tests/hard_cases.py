"""Scenes that break naive float32 ray tracing: each with its reason and what must hold.

Most are four-spheres (`BASE`) with one thing made extreme. tests/test_numerics.py renders them all.
"""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from msgspec.structs import replace
from numpy.typing import DTypeLike

from clrt import (
    AmbientLight,
    Camera,
    DirectionalLight,
    Light,
    Material,
    Scene,
    Sphere,
    SpotLight,
    load_scene,
)
from clrt.film.metrics import QUARTER_STEP
from clrt.renderer.pack.features import Features, features_of
from clrt.renderer.pack.structs import FilmKind
from clrt.renderer.pack.world import pack_world
from clrt.scene.light import LightKind
from clrt.values import Vec3


@dataclass(frozen=True, eq=False)  # hashed by identity: a scene has no hash
class HardCase:
    """A scene and its pass rule: against the "exact" truth, and always free of NaN and infinity.

    Colours are clipped to [0, 1]; a pixel's error is its worst channel's. A flip is a pixel that
    is off by more than 1/1020: its path went another way. Flips must lie at edges of the truth.
    """

    name: str
    reason: str
    scene: Scene
    size: tuple[int, int] = (300, 200)
    dtype: DTypeLike = np.float64  # of the truth: longdouble where float64 is in doubt
    error: float = QUARTER_STEP  # allowed off flips
    double: float = QUARTER_STEP  # in double
    flips: int = 2  # allowed
    check: Literal["truth", "black", "finite"] = "truth"
    literal_fails: bool = False  # the paper's formula in float32 must not pass
    limit: str = ""  # why robust, but not double, is known to fail: docs/accuracy.md


BASE = replace(load_scene("four-spheres"), shadow_bias=0.0)
RED, MAGENTA, GREEN, PLANE = BASE.spheres
SUN = Light((5.0, 5.0, 5.0))
assert BASE.lights == (SUN,)
GROUND: Vec3 = (0.0, -0.7, 0.0)  # the plane's surface below the scene
UP: Vec3 = (0.0, 1.0, 0.0)
LAMP: Vec3 = (0.3, 0.5, -0.5)
TILTED: Vec3 = (0.2, 1.0, 0.1)


def at(center: Vec3, radius: float, material: str = "red") -> Sphere:
    return Sphere(center=center, radius=radius, material=material)


def on(*spheres: Sphere, base: Scene = BASE) -> Scene:
    """`base` with other spheres on its plane."""
    return replace(base, spheres=(*spheres, base.spheres[-1]))


def seen_from(position: Vec3, look_at: Vec3, base: Scene = BASE, fov: float = 90.0) -> Scene:
    return replace(base, camera=Camera(position=position, look_at=look_at, fov=fov))


def lit_from(*positions: Vec3, base: Scene = BASE) -> Scene:
    return replace(base, lights=tuple(Light(position=p) for p in positions))


def made_of(base: Scene = BASE, **changes: Any) -> Scene:
    """`base` with something changed in all its materials."""
    materials = {name: replace(m, **changes) for name, m in base.materials.items()}
    return replace(base, materials=materials)


def plane(radius: float, up: Vec3 = UP, point: Vec3 = GROUND) -> Sphere:
    """A sphere whose surface goes through `point`, where its normal is `up`."""
    length = math.hypot(*up)
    x, y, z = (p - radius * u / length for p, u in zip(point, up, strict=True))
    return at((x, y, z), radius, "plane")


def on_plane(radius: float, up: Vec3 = UP) -> Scene:
    return replace(BASE, spheres=(RED, MAGENTA, GREEN, plane(radius, up)))


def moved(by: Vec3, scale: float = 1.0, base: Scene = BASE) -> Scene:
    """`base`, scaled and then moved, camera and lights with it."""

    def there(p: Vec3) -> Vec3:
        return p[0] * scale + by[0], p[1] * scale + by[1], p[2] * scale + by[2]

    camera = base.camera
    return replace(
        base,
        camera=replace(camera, position=there(camera.position), look_at=there(camera.look_at)),
        lights=tuple(
            replace(light, position=there(light.position))
            for light in base.lights
            if isinstance(light, Light)
        ),
        spheres=tuple(
            replace(s, center=there(s.center), radius=s.radius * scale) for s in base.spheres
        ),
    )


def scaled(scale: float, base: Scene = BASE) -> Scene:
    return moved((0.0, 0.0, 0.0), scale, base)


def join(*scenes: Scene) -> Scene:
    """All the spheres of some scenes, with the rest of the first."""
    return replace(scenes[0], spheres=tuple(s for scene in scenes for s in scene.spheres))


def corridor(depth: int) -> Scene:
    """Two mirrors of radius 1e4, two units apart, a small sphere between them."""
    mirror = Material(
        ambient=(0.02, 0.02, 0.02),
        diffuse=(0.0, 0.0, 0.01),
        specular=(0.0, 0.0, 0.0),
        shininess=100.0,
        reflection=1.0,
    )
    walls = (at((-10001.0, 0.0, 0.0), 1e4, "mirror"), at((10001.0, 0.0, 0.0), 1e4, "mirror"))
    return replace(
        seen_from((0.0, 0.0, 1.0), (0.5, 0.1, 0.0)),
        max_depth=depth,
        materials={**BASE.materials, "mirror": mirror},
        spheres=(*walls, at((0.3, -0.2, -1.0), 0.2, "green")),
        lights=(Light(position=(0.0, 0.3, 3.0)),),
    )


def planet() -> Scene:
    """Big mirrors around a planet show its far side, with things resting on it, to a camera near
    its surface."""
    resting = [
        at((math.sin(a) * 102.0, math.cos(a) * 102.0, 10.0 * (i - 5)), 3.0, "green")
        for i, a in enumerate(np.linspace(0.3, 6.0, 11))
    ]
    mirrors = [
        at((250.0, 100.0, -100.0), 60.0, "red"),
        at((-200.0, 150.0, -200.0), 80.0, "magenta"),
        at((30.0, 260.0, -250.0), 90.0, "red"),
    ]
    scene = seen_from((0.0, 101.0, 0.0), (0.0, 130.0, -60.0), made_of(reflection=0.9), fov=120.0)
    return replace(
        lit_from((0.0, 2000.0, 3000.0), (0.0, -1500.0, -1000.0), base=scene),
        max_depth=5,
        spheres=(*mirrors, *resting, at((0.0, 0.0, 0.0), 100.0, "plane")),
    )


def far_giant(radius: float, height: float) -> Scene:
    """four-spheres on a ball, through a long lens from a place where the ball is no giant: the rays
    bounce near a surface that the camera is far from."""
    fov = math.degrees(1.7 / height)
    return seen_from((0.0, height, height), (-0.1, -0.2, -0.5), on_plane(radius), fov)


def highlight(shininess: float) -> Scene:
    """The highlight of the red sphere, filling the picture."""
    center, eye = np.array(RED.center), np.array(BASE.camera.position)
    light = np.array(SUN.position)
    point = center + np.array((0.0, 0.0, RED.radius))
    for _ in range(50):  # to where N = H
        to_light, to_eye = light - point, eye - point
        half = to_light / np.linalg.norm(to_light) + to_eye / np.linalg.norm(to_eye)
        point = center + RED.radius * half / np.linalg.norm(half)
    look_at = (float(point[0]), float(point[1]), float(point[2]))
    scene = made_of(shininess=shininess)
    return seen_from(BASE.camera.position, look_at, scene, math.degrees(17 / math.sqrt(shininess)))


def low_sun(radius: float, up: Vec3) -> Scene:
    """A sun that sets 2 units from the middle of the plane: the line between day and night goes
    through the picture. There N.L changes by only 1 / radius a unit."""
    normal = np.array(up) / math.hypot(*up)
    right = np.cross(normal, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    sun = GROUND + 1e4 * (right * math.cos(2 / radius) + normal * math.sin(2 / radius))
    return lit_from((float(sun[0]), float(sun[1]), float(sun[2])), base=on_plane(radius, up))


def backs(light: Vec3) -> Scene:
    """The far side of a ball in two mirrors, left and right of it, and `light` behind.

    The ray from the camera through x = 1/3, y = 0 on the screen hits a mirror in (1, 0, -2), and
    then the ball in (0, 0, -1.5), straight behind its centre.
    """
    eye, mirror, back = (np.array(p) for p in ((0.0, 0, 1), (1.0, 0, -2), (0.0, 0, -1.5)))
    come, go = mirror - eye, back - mirror
    normal = go / np.linalg.norm(go) - come / np.linalg.norm(come)
    x, _, z = mirror - 0.8 * normal / np.linalg.norm(normal)
    return replace(
        lit_from(light, (1.0, 3.0, 2.0), (-1.0, 3.0, 2.0), base=made_of(reflection=0.9)),
        spheres=(at((0, 0, -1), 0.5, "green"), at((x, 0, z), 0.8), at((-x, 0, z), 0.8)),
    )


def telephoto(distance: float) -> Scene:
    """four-spheres without its plane, filling the picture from far away."""
    fov = 2 * math.degrees(math.atan(1.2 / distance))
    return seen_from(
        (0.0, 0.0, distance), (0.0, 0.0, 0.0), replace(BASE, spheres=(RED, MAGENTA, GREEN)), fov
    )


def cases() -> Iterable[HardCase]:
    yield HardCase("base", "four-spheres as it is, no bias", BASE)

    # Where and how large
    for by in ((1e5, 1e5, 1e5), (1e5, -1e5, 1e5), (-1e7, 1e7, 1e7)):
        yield HardCase(
            f"moved-{by[0]:g},{by[1]:g},{by[2]:g}",
            "world coordinates lose their last digits: only distances from the camera count",
            moved(by),
            dtype=np.longdouble,
        )
    for scale in (1e-4, 1e4):
        yield HardCase(f"scaled-{scale:g}", "no length is special", scaled(scale))
    for scale in (1e-25, 1e20):
        yield HardCase(f"scaled-{scale:g}", "squares leave float32's range", scaled(scale))
    for scale in (1e-180, 1e180):
        yield HardCase(
            f"scaled-{scale:g}", "squares leave float64's range", scaled(scale), dtype=np.longdouble
        )
    yield HardCase(
        "turned",
        "no axis is special: camera and plane at odd angles",
        replace(
            on_plane(8999.3, (0.3, 0.8, -0.2)),
            camera=Camera(position=(0.3, 0.4, 1.1), look_at=(-0.1, -0.2, 0.0), up=(0.5, 0.7, 0.1)),
        ),
        literal_fails=True,
    )

    # Planes: the larger the radius, the fewer digits of |f|^2 - r^2 are left
    for radius in (1e4, 1e5, 1e6, 1e7, 1e8, 1e9):
        for name, up in (("", UP), ("-tilted", TILTED)):
            yield HardCase(
                f"plane-{radius:g}{name}",
                f"float32 holds a radius of {radius:g} to {radius * 2**-24:.1g}",
                on_plane(radius, up),
                dtype=np.longdouble if radius >= 1e7 else np.float64,
                error=1e-4,
                flips=0,
                literal_fails=radius > 1e4 or up is TILTED,
            )
    # Its top must be a float64: 0.75 * 2^30 below the camera.
    yield HardCase(
        "plane-2^70",
        "a very flat plane, whose square leaves float32's range",
        replace(
            scaled(2.0**30),
            spheres=(
                *scaled(2.0**30).spheres[:3],
                at((0.0, -(2.0**70) - 0.75 * 2.0**30, 0.0), 2.0**70, "plane"),
            ),
        ),
        dtype=np.longdouble,
        literal_fails=True,
    )
    for height in (1e-3, 1e-6):
        ball = plane(1e3, point=(0.0, -height, 1.0))
        yield HardCase(
            f"camera-{height:g}-above",
            "the camera almost touches a ball of radius 1e3",
            replace(BASE, spheres=(RED, MAGENTA, GREEN, ball)),
            dtype=np.longdouble,
            literal_fails=height == 1e-6,
        )
    for radius, height in ((1e3, 35.0), (1e3, 200.0), (1e4, 345.0), (1e5, 3500.0)):
        yield HardCase(
            f"far-giant-{radius:g}-{height:g}",
            "a large ball that is no giant from the camera, but is from where its rays bounce",
            far_giant(radius, height),
            dtype=np.longdouble,
            literal_fails=radius > 1e3,
        )
    yield HardCase(
        "giant-from-afar",
        "a ball that the camera almost touches darkens ground 1e4 radii away",
        seen_from(
            *((0.0, 0.0, 1.0), (-1.0, 0.0, 1.0)),
            lit_from((0.75, 0.67, 1.0), base=on(at((0.0, 0.67, 1.0), 0.65), base=on_plane(1e9))),
            fov=0.5,
        ),
        check="black",
    )
    yield HardCase("planet", "rays that travel all over a giant", planet(), size=(240, 160))
    yield HardCase(
        "two-places",
        "1e6 units wide, with detail at both ends and a mirror beside the camera",
        join(on_plane(1e9), moved((3e5, 1e5, -1e6), 3e5), moved((-4e5, 1e5, -1e6), 1e5)),
        dtype=np.longdouble,
        literal_fails=True,
    )
    for radius in (1e4, 1e6):
        for name, up in (("", UP), ("-tilted", TILTED)):
            yield HardCase(
                f"low-sun-{radius:g}{name}",
                "the line between day and night on a plane, where N.L changes slowly",
                low_sun(radius, up),
                dtype=np.longdouble,
                literal_fails=True,
                limit="N.L is off by 2^-24, the line by 2^-24 r" * (radius > 1e4 and up is TILTED),
            )
    for distance in (9.0, 1e2, 1e4, 1e5):
        yield HardCase(
            f"telephoto-{distance:g}",
            "small angles: what is seen is far away against its size",
            telephoto(distance),
            dtype=np.longdouble,
            literal_fails=distance == 9.0,
        )

    # Contacts
    yield HardCase(
        "touching",
        "two spheres that share one point",
        on(at((-0.25, 0.0, 0.0), 0.25), at((0.25, 0.0, 0.0), 0.25, "green")),
    )
    yield HardCase(
        "touching-inside",
        "a sphere inside another that it touches where both face the camera",
        on(at((0.0, 0.0, -0.75), 0.25, "green"), at((0.0, 0.0, -1.0), 0.5)),
    )
    yield HardCase(
        "overlapping",
        "spheres that go through each other",
        on(
            at((-0.2, 0.0, 0.0), 0.4),
            at((0.2, 0.0, 0.1), 0.4, "green"),
            at((0.0, 0.3, -0.1), 0.4, "magenta"),
        ),
    )
    yield HardCase(
        "concentric",
        "spheres inside each other",
        on(
            *(at((0.0, 0.0, -0.5), r, m) for r, m in ((0.3, "green"), (0.5, "red"), (0.4, "plane")))
        ),
    )
    yield HardCase(
        "almost-coincident",
        "two surfaces 1e-5 apart",
        on(at((0.0, 0.0, -0.5), 0.5, "green"), at((0.0, 0.0, -0.5), 0.50001)),
    )
    yield HardCase(
        "coincident",
        "the same sphere twice: the first of the list counts",
        on(at((0.1, 0.0, -0.5), 0.5, "green"), at((0.1, 0.0, -0.5), 0.5)),
    )
    yield HardCase(
        "coincident-planes",
        "the same giant twice",
        replace(BASE, spheres=(*BASE.spheres, replace(PLANE, material="green"))),
    )
    yield HardCase(
        "resting",
        "spheres that touch the plane in one point",
        on(*(at((0.4 * i, -0.7 + 0.15, -0.3 * i * i), 0.15) for i in (-2, -1, 0, 1, 2))),
    )
    yield HardCase(
        "sunk", "spheres cut by the plane", on(at((-0.3, -0.7, 0.0), 0.3), at((0.4, -0.75, 0), 0.2))
    )

    # The camera
    yield HardCase(
        "camera-inside",
        "a sphere cannot be seen from inside",
        on(RED, MAGENTA, GREEN, at((0.0, 0.0, 1.2), 0.5)),
    )
    yield HardCase(
        "camera-on-surface",
        "the camera exactly on spheres, one before it and one behind",
        on(RED, MAGENTA, GREEN, at((0.0, 0.0, 0.5), 0.5), at((0.0, 0.0, 2.0), 1.0)),
    )
    yield HardCase(
        "camera-on-giant",
        "the camera exactly on a giant",
        replace(BASE, spheres=(RED, MAGENTA, GREEN, at((0.0, -1024.0, 1.0), 1024.0, "plane"))),
    )
    yield HardCase(
        "camera-under-giant",
        "the camera just below a giant's surface, looking out of it",
        replace(BASE, spheres=(RED, MAGENTA, GREEN, plane(1e3, point=(0.0, 1e-3, 1.0)))),
    )
    yield HardCase(
        "behind-camera",
        "spheres behind the camera are only seen in mirrors",
        on(*BASE.spheres[:3], at((0.0, 0.5, 3.0), 1.0, "green"), at((-1.0, 0.0, 1.5), 0.3)),
    )
    yield HardCase("wide", "a lens of 170 degrees", seen_from((0, 0, 1), (0, 0, 0), fov=170.0))

    # Lights
    yield HardCase(
        "light-inside", "the light in a sphere", lit_from((-0.32, 0.02, 0.04)), check="black"
    )
    yield HardCase(
        "light-inside-plane", "the light in a giant", lit_from((1.0, -2.0, 0.0)), check="black"
    )
    for radius in (1e-2, 1e-4):
        yield HardCase(
            f"light-in-{radius:g}",
            "the light in a small ball: is the ball before or behind it?",
            lit_from(LAMP, base=on(RED, MAGENTA, GREEN, at(LAMP, radius))),
            check="black",
            literal_fails=True,
        )
    yield HardCase(
        "light-before-1e-3",
        "the light just before a small ball",
        lit_from(LAMP, base=on(RED, MAGENTA, GREEN, at((0.3, 0.5, -0.51), 1e-3))),
        literal_fails=True,
    )
    yield HardCase("light-at-camera", "L = V = H", lit_from((0.0, 0.0, 1.0)))
    yield HardCase("light-behind", "long shadows towards the camera", lit_from((0.5, 1.0, -6.0)))
    yield HardCase(
        "light-on-surface",
        "ill-posed: a light exactly on a sphere",
        lit_from((-0.2, 0.0, -0.3)),
        check="finite",
    )
    yield HardCase(
        "light-on-plane",
        "ill-posed: a light exactly on a giant",
        replace(
            lit_from((0.0, -1.0, 0.0)),
            spheres=(RED, MAGENTA, GREEN, at((0.0, -1025.0, 0.0), 1024.0, "plane")),
        ),
        check="finite",
    )
    yield HardCase(
        "light-near-plane",
        "N.L changes within a few pixels",
        lit_from((0.2, -0.699, 0.3)),
        literal_fails=True,
    )
    for far in (1e6, 1e12):
        yield HardCase(
            f"light-at-{far:g}",
            "a sun: the light much farther than the scene",
            lit_from((far, far, far)),
        )
    yield HardCase(
        "light-at-1e25",
        "the square of the light's distance leaves float32's range",
        lit_from((1e25, 1e25, 1e25)),
    )
    yield HardCase(
        "light-at-1e200",
        "the light's distance leaves float32's range, its square float64's",
        lit_from((1e200, 1e200, 1e200)),
        dtype=np.longdouble,
    )
    yield HardCase(
        "lights",
        "three lights, of which each point sees others",
        lit_from(
            *((5.0, 5.0, 5.0), (-3.0, 0.5, 1.0), (0.0, 9.0, -3.0)),
            base=made_of(diffuse=(0.3, 0.2, 0.1), specular=(0.3, 0.3, 0.3)),
        ),
    )
    yield HardCase("no-lights", "nothing to see", replace(BASE, lights=()), check="black")
    yield HardCase(
        "bright",
        "colours whose products leave float32's range",
        replace(
            BASE, lights=(Light((5.0, 5.0, 5.0), ambient=(1e300,) * 3, specular=(-1e300,) * 3),)
        ),
        check="finite",
    )
    yield HardCase(
        "grazing-light",
        "N.L is exactly 0 where the middle ray hits",
        replace(lit_from((5.0, 5.0, -0.5)), spheres=(at((0.0, 0.0, -1.0), 0.5),), max_depth=1),
        size=(301, 201),
    )
    yield HardCase(
        "backs",
        "N.V < 0: the far side of a ball, lit from there, in mirrors",
        backs((0.5, 0.3, -6.0)),
    )
    yield HardCase(
        "opposite",
        "ill-posed in pixels (100, 100) and (200, 100): L + V = 0, H is undefined",
        backs((0.0, 0.0, -6.0)),
        size=(301, 201),
        check="finite",
    )

    # Materials and depth
    for shininess in (0.0, 1.0, 1e4, 1e6):
        yield HardCase(
            f"shininess-{shininess:g}",
            "(N.H)^e: rounding grows with e; 0^0 is 1",
            made_of(shininess=shininess, specular=(0.2, 0.3, 0.1)),
        )
    yield HardCase(
        "highlight-1e8",
        "the rounding of N.H, magnified by the exponent 2.5e7",
        highlight(1e8),
        dtype=np.longdouble,
        literal_fails=True,
    )
    yield HardCase(
        "shininess-1e300",
        "an exponent outside float32: infinity times 0",
        made_of(shininess=1e300),
        dtype=np.longdouble,
    )
    yield HardCase("deep", "the sphere's mirror images to depth 50", replace(BASE, max_depth=50))
    yield HardCase(
        "corridor",
        "50 reflections between mirrors of radius 1e4",
        corridor(50),
        size=(150, 100),
        literal_fails=True,
    )

    # Sizes
    for radius in (1e-30, 1e-40):
        yield HardCase(
            f"radius-{radius:g}",
            "the square is 0 in float32, too small to see anyway",
            replace(BASE, spheres=(*BASE.spheres, at((0.05, 0.02, 0.5), radius, "green"))),
        )
    yield HardCase(
        "dust",
        "spheres of a hundredth of a pixel to a pixel",
        on(
            *(
                at((math.cos(i) * i / 200, math.sin(i) * i / 300, -i / 100), 1e-4 * 1.03**i, "red")
                for i in range(200)
            ),
        ),
        size=(150, 100),
    )
    for width, height in ((1, 1), (1, 7), (7, 1), (17, 3)):
        yield HardCase(
            f"size-{width}x{height}",
            "packets that stick out; linspace of one number",
            BASE,
            size=(width, height),
        )
    yield HardCase("empty", "no sphere at all", replace(BASE, spheres=()), check="black")
    yield from orthographic_cases()
    yield from light_cases()
    yield from glass_cases()


GLASS = Material(diffuse=(0.05, 0.05, 0.05), specular=(0.5, 0.5, 0.5), transmission=0.9)
CLEAR = Material(diffuse=(0.0, 0.0, 0.0), transmission=1.0, ior=1.0)
MIDDLE: Vec3 = (0.0, -0.1, -0.2)


def with_glass(*spheres: Sphere, depth: int = 8, base: Scene = BASE, **glass: Any) -> Scene:
    """`base`, and in front of it spheres of "glass", "air" and "diamond"."""
    made = replace(GLASS, **glass)
    materials = {"glass": made, "air": replace(made, ior=1.0), "diamond": replace(made, ior=2.4)}
    return replace(
        base,
        max_depth=depth,
        materials={**base.materials, **materials},
        spheres=(*base.spheres, *spheres),
    )


def glass_cases() -> Iterable[HardCase]:
    """Rays through spheres. In double all are off by less than 1e-6."""

    def case(name: str, reason: str, scene: Scene, **more: Any) -> HardCase:
        return HardCase(f"glass-{name}", reason, scene, (240, 160), np.longdouble,
                        double=1e-6, **more)  # fmt: skip

    ball, bubble = at(MIDDLE, 0.5, "glass"), at(MIDDLE, 0.49, "air")
    left, right = (-0.25, -0.1, -0.2), (0.25, -0.1, -0.2)
    for name, reason, spheres in (
        ("ball", "a chord from its own sphere", [ball]),
        ("bubble", "rays that are inside of two spheres", [ball, bubble]),
        ("thin-shell", "a shell of 1e-4 radii", [ball, at(MIDDLE, 0.49995, "air")]),
        ("air-in-glass", "total reflection", [ball, at((0.1, 0.0, -0.1), 0.2, "air")]),
        ("core", "an opaque ball inside", [ball, at(MIDDLE, 0.25, "green")]),
        ("overlapping", "the smaller one's medium counts",
         [at((-0.2, -0.1, -0.2), 0.4, "glass"), at((0.2, -0.1, -0.2), 0.35, "diamond")]),
        ("overlapping-equal", "of equal ones the first counts",
         [at((-0.2, -0.1, -0.2), 0.4, "glass"), at((0.2, -0.1, -0.2), 0.4, "diamond")]),
        ("touching", "two that share a point", [at(left, 0.25, "glass"), at(right, 0.25, "glass")]),
        ("tiny", "a ball of 1e-3 before the camera", [at((0.0005, 0.0, 0.995), 1e-3, "glass")]),
        ("core-touches", "an opaque ball that touches the glass from inside",
         [ball, at((0.0, -0.1, 0.05), 0.25, "green")]),
        ("nested-4", "as many as a ray can be inside of",
         [at(MIDDLE, r, m) for r, m in ((0.5, "glass"), (0.4, "air"), (0.3, "diamond"),
                                        (0.2, "air"))]),
        ("camera-in-a-ball", "the camera is inside of glass", [at((0.0, 0.1, 1.1), 0.5, "glass")]),
        ("camera-in-two", "and of two, one beside the other's middle",
         [at((0.0, 0.1, 1.1), 0.5, "glass"), at((0.1, 0.0, 1.2), 0.4, "air")]),
    ):  # fmt: skip
        yield case(name, reason, with_glass(*spheres))
    row = [at((0.45 * i - 0.9, 0.05 * i, -0.3 * i + 0.1), 0.22, "diamond") for i in range(5)]
    yield case("row", "five diamonds, each of which magnifies", with_glass(*row), flips=40)
    yield case(
        "water",
        "the far side of a giant",
        with_glass(plane(1e4, point=(0.0, -0.3, 0.0)), ior=1.33),
    )
    sunk = replace(plane(1e4, point=(0.0, -0.3, 0.0)), material="glass")
    yield case("lake", "opaque balls in the water, seen from above", with_glass(sunk, ior=1.33))
    yield case("index-1", "as if it were not there, but traced", with_glass(ball, ior=1.0))
    yield case("both", "mirrored and transmitted", with_glass(ball, reflection=0.1))
    yield case("fresnel", "by the angle", with_glass(ball, bubble, fresnel=True))
    yield case(
        "fresnel-deep",
        "paths of 24 segments, which magnify, and many rays put aside: flips at edges of edges",
        with_glass(ball, at((0.8, 0.2, -0.2), 0.3, "diamond"), depth=24, fresnel=True),
        flips=130,
    )
    two = lit_by(Light((-5.0, 5.0, 5.0)), SUN, AmbientLight((0.2, 0.2, 0.2)))
    yield case("shadows", "of glass on glass", with_glass(ball, *row[:2], base=two))
    inside = lit_by(Light((0.1, 0.0, -0.1)))
    yield case("light-inside", "it pays for the way in", with_glass(ball, base=inside))
    camera = Camera((0.0, 0.1, 1.1), (0.0, 0.0, 0.0), fov=5.0)
    long_lens = replace(with_glass(at((0.0, 0.1, 1.1), 0.3, "glass")), camera=camera)
    yield case("long-lens-inside", "a long lens inside of glass", long_lens)
    yield case(
        "beside", "an orthographic camera", with_glass(ball, bubble, base=beside((1.0, 1.0, 1.0)))
    )
    far = (1e5, -1e5, 1e5)
    yield case("moved", "far from the origin", moved(far, base=with_glass(ball, bubble)))


def lit_by(*lights: LightKind, base: Scene = BASE) -> Scene:
    return replace(base, lights=lights)


def under(spot: SpotLight) -> Scene:
    """`BASE` with the disc that a narrow spot lights filling half the picture."""
    lamp, aim, eye = (np.array(v) for v in (spot.position, spot.look_at, BASE.camera.position))
    axis = (aim - lamp) / np.linalg.norm(aim - lamp)
    roots = []
    for sphere in BASE.spheres:
        away = lamp - np.array(sphere.center)
        b, c = away @ axis, away @ away - sphere.radius**2
        if b < 0 < b * b - c:
            roots.append(-b - math.sqrt(b * b - c))
    x, y, z = lamp + min(roots) * axis
    width = 4 * min(roots) * math.tan(math.radians(spot.outer_angle))
    fov = 2 * math.degrees(math.atan(width / 2 / np.linalg.norm((x, y, z) - eye)))
    return seen_from(BASE.camera.position, (float(x), float(y), float(z)), fov=fov)


def light_cases() -> Iterable[HardCase]:
    """Lights of all kinds, and Phong's highlight. In double all are off by less than 1e-7."""

    def case(name: str, reason: str, *lights: LightKind, **more: Any) -> HardCase:
        scene = lit_by(*lights, base=more.pop("base", BASE))
        return HardCase(name, reason, scene, dtype=np.longdouble, double=1e-7, **more)

    for name, reason, position, attenuation in (
        ("quadratic", "no constant part", (5.0, 5.0, 5.0), (0.0, 0.0, 0.01)),
        ("all-parts", "the paper's", (5.0, 5.0, 5.0), (1.0, 0.2, 0.05)),
        ("near-plane", "distances from 1e-3 on", (0.3, GROUND[1] + 1e-3, -0.5), (0.0, 0.0, 1.0)),
        ("at-1e12", "the square of the distance is 1e24", (1e12, 1e12, 1e12), (0.0, 0.0, 1e-24)),
        ("at-1e20", "farther than lights are kept", (1e20, 1e20, 1e20), (0.0, 0.0, 1e-40)),
    ):
        yield case(f"attenuation-{name}", reason, Light(position, attenuation=attenuation))
    for by in ((1e5, -1e5, 1e5), (-1e7, 1e7, 1e7)):
        lit = lit_by(Light((1.0, 1.0, 1.0), attenuation=(0.1, 0.3, 0.5)))
        yield HardCase(f"attenuation-moved-{by[0]:g}", "and moved", moved(by, 1, lit), double=1e-6,
                       dtype=np.longdouble)  # fmt: skip
    x, y, z = RED.center
    yield case(
        "attenuation-at-0",
        "ill-posed: a light on a sphere, at distance 0 from a point",
        Light((x, y, z + RED.radius), attenuation=(0.0, 0.0, 1.0)),
        check="finite",
    )
    for c in (1e-30, 1e-300, 1e300):
        weak = Light((5.0, 5.0, 5.0), attenuation=(0.0, 0.0, c))
        yield case(f"attenuation-{c:g}", "1 / C D^2 leaves float32", weak, check="finite")

    above = (0.3, 1.4, 0.2)
    for name, reason, outer, inner, error in (
        ("3-6", "narrow", 6.0, 3.0, QUARTER_STEP),
        ("sharp", "an edge 0.001 degrees wide", 20.0, 19.999, QUARTER_STEP),
        ("hard", "no width at all", 20.0, 20.0, QUARTER_STEP),
        ("0.1-0.4", "1 - cosine has lost its digits", 0.4, 0.1, QUARTER_STEP),
        ("0.01-0.04", "only |L + axis|^2 has some", 0.04, 0.01, QUARTER_STEP),
        ("60-90", "a half space", 90.0, 60.0, QUARTER_STEP),
        ("0-180", "dark in one direction only", 180.0, 0.0, QUARTER_STEP),
    ):
        spot = SpotLight(above, (-0.1, -0.2, -0.4), outer_angle=outer, inner_angle=inner)
        base = under(spot) if outer < 1 else BASE
        yield case(f"spot-{name}", reason, spot, base=base, error=error)
    fading = SpotLight(above, (-0.1, -0.2, -0.4), attenuation=(0.2, 0.1, 0.3), outer_angle=30.0)
    yield case("spot-and-attenuation", "both, and a light that is neither", fading, SUN)
    away = SpotLight((5.0, 5.0, 5.0), (9.0, 9.0, 9.0))
    yield case("spot-looks-away", "nothing of it is seen", away, check="black")
    inside = SpotLight((-0.32, 0.02, 0.04), (0.0, 0.0, 0.0))
    yield case("spot-in-a-ball", "it lights nothing", inside, check="black")
    yield case(
        "spot-far",
        "7e6 away, its cone 1.2 units wide there",
        SpotLight((3e6, 4e6, 5e6), (-0.1, -0.2, -0.4), outer_angle=1e-5, inner_angle=0.0),
        limit="the direction of a light is rounded to 2^-24, the half of this cone",
    )

    yield case("directional", "infinitely far", DirectionalLight((-1.0, -2.0, -0.5)))
    yield case("directional-oblique", "along the plane", DirectionalLight((-1.0, -0.02, 0.3)))
    yield case(
        "directional-1e-200", "a length that has no square", DirectionalLight((-1e-200,) * 3)
    )
    yield case(
        "directional-horizon",
        "1e-3 over the horizon of a giant",
        DirectionalLight((-1.0, -1e-3, 0.0)),
        base=on_plane(1e6),
    )
    for up in (UP, TILTED):
        straight = (-up[0], -up[1], -up[2])
        yield case(
            f"directional-down-{up[0]:g}",
            "straight down on a plane of radius 1e9",
            DirectionalLight(straight),
            base=on_plane(1e9, up),
        )
    yield case("ambient-alone", "a mirror goes on in shadow", AmbientLight((1.0, 0.9, 0.8)))
    yield case("ambient-and-shadow", "and with a light", AmbientLight((0.5, 0.5, 0.5)), SUN)
    yield case(
        "four-kinds",
        "all together",
        AmbientLight((0.2, 0.2, 0.3)),
        DirectionalLight((-1.0, -2.0, -0.5), diffuse=(0.4, 0.4, 0.3)),
        SpotLight(above, (-0.1, -0.2, -0.4), attenuation=(0.5, 0.0, 0.5)),
        Light((2.0, 1.0, 1.0), attenuation=(0.3, 0.2, 0.1)),
        base=made_of(highlight="phong"),
    )
    for shininess in (0.0, 1.0, 100.0, 1e4, 1e6):
        yield case(
            f"phong-{shininess:g}",
            "(R.V)^n: rounding grows with n; 0^0 is 1",
            SUN,
            base=made_of(highlight="phong", shininess=shininess, specular=(0.2, 0.3, 0.1)),
        )
    yield case(
        "phong-grazing",
        "N.L = 0: R and L are one line",
        Light((0.0, GROUND[1] + 1e-7, -3.0)),
        base=made_of(highlight="phong", shininess=3.0),
        check="finite",
    )
    mixed = {
        name: replace(m, highlight="phong" if name in ("red", "plane") else "blinn-phong")
        for name, m in BASE.materials.items()
    }
    yield case("phong-and-blinn", "in one packet", SUN, base=replace(BASE, materials=mixed))


def beside(position: Vec3, look_at: Vec3 = (0.0, 0.0, 0.0), height: float = 2.0) -> Scene:
    """`BASE` through an orthographic camera."""
    camera = Camera(position, look_at, projection="orthographic", height=height)
    return replace(BASE, camera=camera)


def orthographic_cases() -> Iterable[HardCase]:
    """The lines of an orthographic camera start before everything, wherever it stands."""
    for name, scene, reason in (
        (
            "beside",
            beside((0.0, 0.0, 1.0)),
            "below the horizon lines meet the plane 112 units back",
        ),
        ("above", beside((1.0, 1.0, 1.0)), "every line ends on the plane"),
        (
            "behind-position",
            beside((0.0, 0.2, -9.0), (0.0, 0.1, -10.0)),
            "all is behind the camera",
        ),
        ("in-a-ball", beside(RED.center, (-0.2, 0.1, 0.0)), "the camera is inside a ball"),
        (
            "under-ground",
            beside((0.1, -50.0, 0.2), (-0.3, 0.0, -0.1)),
            "seen from inside the plane",
        ),
        ("far", beside((3e5, 2e5, 4e5)), "position is far away"),
        ("wide", beside((1.0, 1.0, 1.0), height=1e5), "a pixel is 500 units wide"),
        ("narrow", beside((1.0, 2.0, 3.0), (-0.2, 0.2, -0.4), 1e-4), "a pixel is 5e-7 units wide"),
        ("no-size", beside((0.0, 0.0, 1.0), height=1e300), "a pixel is wider than float32 can be"),
        ("point", beside((0.0, 0.0, 1.0), height=1e-300), "all pixels are one"),
    ):
        # Ambient light, so that backs and what is far away show.
        lit = replace(scene, lights=(*scene.lights, AmbientLight((0.5, 0.5, 0.5))))
        yield HardCase(f"orthographic-{name}", reason, lit, dtype=np.longdouble)
    for radius in (1e5, 1e7, 1e9):
        for name, up in (("", UP), ("-tilted", TILTED)):
            yield HardCase(
                f"orthographic-plane-{radius:g}{name}",
                "a plane that is met far before the rest",
                replace(on_plane(radius, up), camera=beside((0.0, 0.0, 1.0)).camera),
                dtype=np.longdouble,
                limit="the plane is met sqrt(2 r h) before the rest" * (radius > 1e5 and up is UP),
            )
    seen = beside((1.0, 1.0, 1.0))
    for by in ((1e5, -1e5, 1e5), (-1e7, 1e7, 1e7)):
        name = f"orthographic-moved-{by[0]:g}"
        yield HardCase(name, "only what is seen counts", moved(by, base=seen), dtype=np.longdouble)


CASES = tuple(cases())


def program_of(case: HardCase, film: FilmKind = "float") -> Features:
    """What the case is compiled for, in float32 for 16 lanes."""
    return features_of(pack_world(case.scene, "robust"), case.scene, 16, film)


PROGRAMS = Counter(map(program_of, CASES))
COMMON = 5
"""Cases whose program so many have in common are tried in every way. The others need programs of
their own for each: they are tried in one, and in every way by the slow tests."""


def is_common(case: HardCase) -> bool:
    return PROGRAMS[program_of(case)] >= COMMON
