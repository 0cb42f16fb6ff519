"""python -m benchmarks: speed beside error, on this machine."""

import click

from benchmarks import (
    accuracy,
    animation,
    features,
    many,
    peers,
    readme,
    samples,
    scale,
    speed,
    targets,
    view,
    visibility,
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--quick", is_flag=True, help="Small and few: only shows that it runs.")
@click.pass_context
def main(context: click.Context, quick: bool) -> None:
    """Measures clrt on this machine; run it with nothing else running.

    Each part prints a table and writes benchmarks/results/<part>.json, which also says on what
    machine and with what versions. With --quick they go to a temporary folder.
    """
    context.obj = quick


main.add_command(accuracy.command)
main.add_command(animation.command)
main.add_command(features.command)
main.add_command(many.command)
main.add_command(peers.command)
main.add_command(readme.command)
main.add_command(samples.command)
main.add_command(scale.command)
main.add_command(speed.command)
main.add_command(targets.command)
main.add_command(view.command)
main.add_command(visibility.command)

if __name__ == "__main__":
    main()
