"""Mitsuba 3 by its Python package (PyPI: mitsuba)."""

import numpy as np

from handed import arguments, hand_back, not_here

try:
    import mitsuba as mi
except ImportError as error:
    not_here(error)

path, folder, _ = arguments()
bitmap = mi.Bitmap(str(path))
pixels = np.array(bitmap)
if pixels.ndim == 2:
    pixels = pixels[:, :, None]
hand_back(
    folder,
    f"Mitsuba {mi.__version__}",
    {field.name: pixels[:, :, i] for i, field in enumerate(bitmap.struct_())},
    tags={name: str(bitmap.metadata()[name]) for name in ("colorInteropID", "chromaticities") if name in bitmap.metadata()},
)
