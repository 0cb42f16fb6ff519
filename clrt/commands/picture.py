"""Picture: which picture of a scene a command is to make, and the file that it goes to."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from clrt.commands.options import stem_of
from clrt.commands.terminal import Progress
from clrt.errors import RequestError

if TYPE_CHECKING:
    from clrt.figure.rendering import Renderer
    from clrt.renderer.checks import Region
    from clrt.scene.scene import Scene


class Picture(NamedTuple):
    """A picture that can be made and written, as far as that is known before its scene is read."""

    output: Path
    """On stdout its suffix is the format."""
    on_stdout: bool
    width: int
    """Of the whole picture, as the height."""
    height: int
    region: "Region | None"
    passes: Sequence[str] | None
    bits: int | None

    @property
    def is_vector(self) -> bool:
        """Whether its words are not pixels."""
        from clrt.files import vector

        return self.output.suffix.lower() in vector.SUFFIXES

    @property
    def dtype(self) -> Any:
        """Of its film."""
        from clrt.files.image import film_dtype

        return film_dtype(self.output, self.bits)

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of the part that is wanted."""
        from clrt.renderer.checks import check_region

        left, top, right, bottom = check_region(self.region, self.width, self.height)
        return right - left, bottom - top

    def check(self, scene: "Scene") -> None:
        """Finds out before rendering whether writing a picture of a scene would fail after it.

        Raises:
            RequestError: the format has no such pictures.
            OutputError: its folder cannot be written to.
        """
        from clrt.files.image import check_output

        has = {"alpha": scene.film.transparent, "passes": self.passes is not None}
        check_output(self.output, *self.size, bits=self.bits, **has)

    def made(self, renderer: "Renderer", scene: "Scene", quiet: bool) -> tuple[Any, dict[str, Any]]:
        """Its pixels, and what else is written to its file: arguments of save()."""
        with Progress(self.size[1], quiet) as progress:
            if self.is_vector:
                from clrt.figure.apart import picture_and_words

                image, overlay = picture_and_words(
                    renderer, scene, self.width, self.height, progress.add
                )
                return image, {"overlay": overlay}
            image, passes = renderer.render(
                scene,
                self.width,
                self.height,
                dtype=self.dtype,
                region=self.region,
                passes=self.passes or (),
                progress=progress.add,
            )
            return image, {"passes": passes}

    def write(self, image: Any, **how: Any) -> None:
        """Writes the file, or its bytes to stdout.

        Args:
            how: of save().
        """
        from clrt.files.image import save

        if not self.on_stdout:
            save(self.output, image, **how)
            return
        from tempfile import TemporaryDirectory

        with TemporaryDirectory() as folder:
            save(Path(folder) / self.output, image, **how)
            sys.stdout.buffer.write((Path(folder) / self.output).read_bytes())


def asked(
    source: str,
    output: Path | None,
    output_format: str | None,
    size: tuple[int, int],
    region: "Region | None",
    passes: str | None,
    bits: int | None,
) -> Picture:
    """The picture of a source that options ask for.

    Raises:
        RequestError: there is no such picture.
    """
    from clrt.files.image import check_apart, check_suffix
    from clrt.renderer.checks import check_passes, check_region, check_size

    on_stdout = str(output) == "-"
    if on_stdout:
        output = Path(f"stdout.{output_format or 'png'}")
    elif output_format is not None:
        raise RequestError("--output-format: expected -o -: else the suffix tells")
    output = output or Path(f"{stem_of(source)}.png")
    check_region(region, *check_size(*size))
    names = None if passes is None else check_passes(passes.split(","))
    check_suffix(output)
    picture = Picture(output, on_stdout, *size, region, names, bits)
    if picture.is_vector and region is not None:
        raise RequestError(f"--region: expected a format of pixels, {output} has words")
    if not on_stdout:
        check_apart(output, Path(source))
    return picture
