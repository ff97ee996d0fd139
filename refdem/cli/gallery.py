"""refdem gallery: the figures of the chapter, computed and drawn."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    figure: Annotated[
        list[str] | None, typer.Argument(help="Figures, as 1.15 or co-4; default: all.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the gallery.")] = Path("reports/gallery"),
) -> None:
    """Computes figures of the source chapter in the reference and draws them: gallery.html,
    gallery.md, a picture each.

    Figures that the folder has already, and that are not named, stay as they are.

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
