"""clrt styles: the looks of particles."""

import click

LOOKS = {
    "soft": "shadows in corners and soft light; the default",
    "matte": "one light from the upper left; the fastest",
    "outline": "a line around each particle, for print",
    "mirror": "the paper's mirrors",
    "ball-and-stick": "as soft, with small balls and the bonds between them",
}


@click.command()
def styles() -> None:
    """Lists the styles of particles: light and surfaces."""
    for name, look in LOOKS.items():
        click.echo(f"{name:16}{look}")
