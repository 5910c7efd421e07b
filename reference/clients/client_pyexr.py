"""pyexr (PyPI: pyexr)."""

from importlib.metadata import version

from handed import arguments, hand_back, not_here

try:
    import pyexr
except ImportError as error:
    not_here(error)

path, folder, _ = arguments()
with pyexr.open(str(path)) as file:
    planes = {}
    for group in file.root_channels | set(file.channel_map):
        if group not in file.channel_map:
            continue
        pixels = file.get(group, precision=pyexr.FLOAT)
        for i, name in enumerate(file.channel_map[group]):
            planes[name] = pixels[:, :, i]
hand_back(folder, f"pyexr {version('pyexr')}", planes)
