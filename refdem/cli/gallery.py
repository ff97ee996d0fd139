"""refdem gallery: the figures of the chapter, computed and drawn."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    figure: Annotated[
        list[str] | None, typer.Argument(help="Figures, such as 1.15 or co-4; default: all.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the gallery.")] = Path("reports/gallery"),
) -> None:
    """Computes and draws figures of the source chapter.

    The reference engine computes them. Writes gallery.html, gallery.md and an image for each
    figure.

    Figures that the folder contains already and that are not named remain unchanged.

    Example: refdem gallery 1.15 1.20 --out gallery
    """
    import refdem
    from refdem.cli.outputs import refuse_unwritable
    from refdem.core.store import Store, default_path
    from refdem.gallery.gallery import figures, names
    from refdem.report import write_gallery

    refuse_unwritable(out)
    made = figures(figure or [])
    write_gallery(out, made, version=refdem.__version__, store=Store(default_path()), every=names())
    print(f"gallery: {out / 'gallery.html'} ({len(made)} figures)")
