"""refdem gallery: the figures of the chapter, computed and drawn."""

from pathlib import Path
from typing import Annotated

import typer


def command(
    figure: Annotated[list[str] | None, typer.Argument(help="Figures, as 1.15; none: all.")] = None,
    out: Annotated[Path, typer.Option(help="Folder for the gallery.")] = Path("reports/gallery"),
) -> None:
    """Computes figures of the source chapter in the reference and draws them: gallery.html, gallery.md, a picture each.

    Example: refdem gallery 1.15 1.20 --out gallery
    """
    import refdem
    from refdem.core.store import Store, default_path
    from refdem.gallery.gallery import figures
    from refdem.report import write_gallery

    made = figures(figure or [])
    write_gallery(out, made, version=refdem.__version__, store=Store(default_path()))
    print(f"gallery: {out / 'gallery.html'} ({len(made)} figures)")
