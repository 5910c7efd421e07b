"""The OpenEXR project's own Python package (PyPI: OpenEXR)."""

import numpy as np

from handed import arguments, hand_back, not_here

try:
    import OpenEXR
except ImportError as error:
    not_here(error)

path, folder, _ = arguments()
with OpenEXR.File(str(path), separate_channels=True) as file:
    header = dict(file.header())
    planes = {name: channel.pixels.copy() for name, channel in file.channels().items()}
low, _ = header["dataWindow"]
first, last = header["displayWindow"]
hand_back(
    folder,
    f"OpenEXR for Python {OpenEXR.__version__}",
    planes,
    place=[int(low[0] - first[0]), int(low[1] - first[1])],
    whole=[int(n) for n in np.subtract(last, first) + 1],
    tags={name: str(header[name]) for name in ("colorInteropID", "chromaticities") if name in header},
)
