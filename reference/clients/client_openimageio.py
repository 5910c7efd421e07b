"""OpenImageIO by its Python package (PyPI: openimageio)."""

from handed import arguments, hand_back, not_here

try:
    import OpenImageIO as oiio
except ImportError as error:
    not_here(error)

path, folder, _ = arguments()
image = oiio.ImageBuf(str(path))
if image.has_error:
    raise SystemExit(image.geterror())
spec = image.spec()
pixels = image.get_pixels(oiio.FLOAT)
hand_back(
    folder,
    f"OpenImageIO {oiio.VERSION_STRING}",
    {name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)},
    place=[spec.x, spec.y],
    whole=[spec.full_width, spec.full_height],
    tags={name: str(spec.getattribute(name)) for name in ("colorInteropID", "chromaticities") if spec.getattribute(name)},
)
