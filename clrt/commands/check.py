"""clrt check: whether a scene file is right."""

import click

from clrt.errors import SceneError, named


@click.command()
@click.argument("scene")
def check(scene: str) -> None:
    """Checks SCENE, a built-in scene's name or a TOML file, and says what is in it."""
    from clrt.figure.resolver import resolved
    from clrt.files.scenefile import load_scene
    from clrt.motion import animation

    loaded = load_scene(scene)
    with named(scene, SceneError):
        loaded = resolved(loaded)
    if loaded.animation is not None:
        with named(scene, SceneError):
            animation.Way(loaded).check(animation.all_frames(loaded))
    click.echo(
        f"{scene}: {len(loaded.spheres)} spheres, {len(loaded.materials)} materials, "
        f"{len(loaded.lights)} lights, max_depth {loaded.max_depth}, "
        f"shadow_bias {loaded.shadow_bias:g}"
    )
