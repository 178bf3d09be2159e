"""Files of the user's own, kept in the folder whose glasses join the catalogue."""

from __future__ import annotations

import shutil
from pathlib import Path

from glassworkbench.errors import GlassWorkbenchError, InputError
from glassworkbench.glass.catalogue import FILE_ENDINGS, catalogue, fillings, read_file
from glassworkbench.output import written_aside
from glassworkbench.settings import user_glasses


def keep(path: str | Path) -> list[str]:
    """Copy a file into the user's folder, so that what it holds is in the catalogue from now on.

    Parameters
    ----------
    path : str or Path
        A file of materials (.toml), or a material card of FreeCAD (.FCMat).

    Returns
    -------
    list of str
        The names of the glasses, then of the fillings.

    Raises
    ------
    InputError
        If the file is faulty, or a name is taken already.
    GlassWorkbenchError
        If the folder cannot be made or written to.
    """
    path = Path(path)
    if path.suffix.lower() not in FILE_ENDINGS:
        raise InputError(f"{path}: is no file of glasses; give one that ends in {' or '.join(FILE_ENDINGS)}")
    library = read_file(path)
    names = [*library.glasses, *library.fillings]
    if not names:
        raise InputError(f"{path}: holds no glass and no filling")
    for name in names:
        if name in catalogue() or name in fillings():
            raise InputError(f"{path}: {name!r} is in the catalogue already; give it another name")
    folder = user_glasses()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise GlassWorkbenchError(f"{folder}: could not be made ({error.strerror or error})") from error
    with written_aside(folder / path.name) as aside:
        shutil.copyfile(path, aside)
    return names
