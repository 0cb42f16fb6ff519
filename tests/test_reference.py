"""The references against the paper's own loop and against closed forms."""

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from benchmarks import paper
from clrt import reference
from clrt.truth import tracer


@pytest.mark.parametrize("name", ["four-spheres", "first-result"])
def test_seed_is_the_papers_loop(name: str) -> None:
    scene = clrt.load_scene(name)
    truth = reference.render(scene, 64, 36, truth="seed")
    assert abs(truth - paper.render(scene, 64, 36)).max() < 1e-12


def test_bands_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = clrt.load_scene("four-spheres")
    whole = reference.trace(scene, 50, 31)
    monkeypatch.setattr(tracer, "CHUNK_PIXELS", 7 * 50)
    bands = reference.trace(scene, 50, 31)
    assert (whole.image == bands.image).all()
    assert (whole.paths == bands.paths).all()


def test_the_two_truths_differ_at_the_terminator_only() -> None:
    scene = clrt.load_scene("four-spheres")
    seed = reference.render(scene, 240, 135, truth="seed")
    exact = reference.render(scene, 240, 135, truth="exact")
    apart = (abs(seed - exact).max(axis=2) > 1e-3).mean()
    assert 0 < apart < 0.005


def test_exact_radiance_of_a_lone_sphere() -> None:
    """Camera, light and normal in one line: L.N = N.H = 1, so the pixel is ka + kd + ks."""
    scene = clrt.Scene(
        clrt.Camera((0, 0, 5), (0, 0, 0)),
        (clrt.Light((0, 0, 9), diffuse=(0.5, 0.5, 0.5)),),
        {"m": clrt.Material((0.1, 0.2, 0.3), (0.4, 0.4, 0.4), (0.25, 0.5, 0), 80)},
        (clrt.Sphere((0, 0, 0), 1, "m"),),
    )
    pixel = reference.render(scene, 3, 3)[1, 1]
    assert pixel == pytest.approx([0.1 + 0.2 + 0.25, 0.2 + 0.2 + 0.5, 0.3 + 0.2], abs=1e-15)


def test_longdouble_agrees_with_float64() -> None:
    scene = replace(clrt.load_scene("four-spheres"), shadow_bias=0.0)
    double = reference.render(scene, 64, 36)
    longer = reference.render(scene, 64, 36, dtype=np.longdouble)
    assert longer.dtype == np.longdouble
    assert abs(double - longer).max() < 1e-9


def test_a_bounce_between_two_mirrors_adds_a_geometric_series() -> None:
    """A ray that goes to and fro between two facing mirrors gathers w + w r + w r^2 + ..."""
    mirror = clrt.Material((0.25, 0, 0), (0, 0, 0), (0, 0, 0), 4, reflection=0.5)
    scene = clrt.Scene(
        clrt.Camera((0, 0, 0), (0, 0, -1)),
        (clrt.Light((0.0, 0.0, 0.5)),),
        {"mirror": mirror},
        (clrt.Sphere((0, 0, -3), 2, "mirror"), clrt.Sphere((0, 0, 3), 2, "mirror")),
        max_depth=4,
    )
    pixel = reference.render(scene, 3, 3)[1, 1]
    assert pixel[0] == pytest.approx(0.25 * (1 + 0.5 + 0.25 + 0.125), abs=1e-15)


def facing(**more: object) -> clrt.Scene:
    """A mirror of radius 1 that faces camera and light."""
    return clrt.Scene(
        clrt.Camera((0, 0, 5), (0, 0, 0)),
        (clrt.Light((0, 0, 9)),),
        {"m": clrt.Material((0.1, 0.2, 0.3), (0, 0, 0), (0, 0, 0), 80, reflection=0.5)},
        (clrt.Sphere((0, 0, 0), 1, "m"),),
        **more,  # type: ignore[arg-type]
    )


def test_the_background_is_seen_directly_and_in_mirrors() -> None:
    film = clrt.Film(background=(1.0, 2.0, 4.0))
    image = reference.render(facing(film=film), 3, 3)
    assert image[1, 1] == pytest.approx([0.1 + 0.5, 0.2 + 1, 0.3 + 2], abs=1e-15)
    assert image[0, 0] == pytest.approx([1, 2, 4], abs=1e-15)
    # A path that ends before it leaves sees nothing: it has no segment left, or no light.
    assert reference.render(facing(film=film, max_depth=1), 3, 3)[1, 1, 0] == pytest.approx(0.1)
    dark = replace(facing(film=film), lights=())
    assert reference.render(dark, 3, 3)[1, 1, 0] == 0
    # Alpha takes the place of what the camera sees directly.
    clear = replace(film, transparent=True)
    trace = reference.trace(facing(film=clear), 3, 3)
    assert trace.alpha.tolist() == [[0, 0, 0], [0, 1, 0], [0, 0, 0]]
    assert (trace.image[1, 1] == image[1, 1]).all()
    assert not trace.image[0, 0].any()


def test_what_the_camera_sees_first() -> None:
    trace = reference.trace(facing(), 3, 3)
    assert trace.id.tolist() == [[-1, -1, -1], [-1, 0, -1], [-1, -1, -1]]
    assert trace.depth[1, 1] == pytest.approx(4, abs=1e-15)
    assert trace.depth[0, 0] == np.inf
    assert trace.normal[1, 1] == pytest.approx([0, 0, 1], abs=1e-15)
    assert not trace.normal[0, 0].any()
    some = reference.trace(facing(), 3, 3, pixels=[(1, 1), (0, 2)])
    assert some.id.tolist() == [0, -1]
    assert some.normal.shape == (2, 3)
    assert some.depth.tolist() == [trace.depth[1, 1], np.inf]


def test_an_orthographic_depth_is_from_where_the_camera_stands() -> None:
    camera = clrt.Camera((0, 0, -7), (0, 0, -8), projection="orthographic", height=6)
    trace = reference.trace(replace(facing(), camera=camera), 7, 7)
    assert trace.depth[3, 3] == pytest.approx(-8, abs=1e-14)
    assert trace.normal[3, 3] == pytest.approx([0, 0, 1], abs=1e-14)
    assert trace.id[3, 3] == 0


def test_unknown_truth() -> None:
    with pytest.raises(ValueError, match="truth"):
        reference.render(clrt.load_scene("four-spheres"), 4, 4, truth="real")  # type: ignore


def test_what_has_a_closed_form_for_truth() -> None:
    scene = facing()
    lens = replace(scene.camera, aperture_radius=0.1, focus_distance=4)
    for changes, key in (
        ({"lights": (clrt.Light((0, 0, 9), radius=1),)}, r"radius of lights\[0\]"),
        ({"lights": (clrt.AmbientLight(occlusion=True),)}, r"occlusion of lights\[0\]"),
        ({"materials": {"m": clrt.Material(roughness=0.1)}}, "roughness of materials.m"),
        ({"camera": lens}, "aperture_radius of camera"),
        ({"indirect": True}, "indirect"),
    ):
        said = f"knows no {key}: closed forms are the truth there"
        for truth in ("seed", "exact"):
            with pytest.raises(clrt.RequestError, match=f"truth: '{truth}' {said}"):
                reference.render(replace(scene, **changes), 3, 3, truth=truth)  # type: ignore


def test_one_sample_whatever_the_scene_says() -> None:
    scene = facing(samples=64)
    assert (reference.render(scene, 3, 3) == reference.render(facing(), 3, 3)).all()
    with pytest.raises(clrt.RequestError, match="'seed' knows no samples > 1, expected 'exact'"):
        reference.render(scene, 3, 3, truth="seed")
