"""OpenCV by its Python package (PyPI: opencv-python-headless)."""

import os

from handed import arguments, hand_back, not_here

# OpenCV does not read EXR files unless it is told so.
os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
try:
    import cv2
except ImportError as error:
    not_here(error)

path, folder, _ = arguments()
image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
if image is None:
    raise SystemExit("imread gives None")
planes = {"Y": image} if image.ndim == 2 else {name: image[:, :, i] for i, name in enumerate("BGRA"[: image.shape[2]])}
hand_back(folder, f"OpenCV {cv2.__version__}", planes, note=str(image.dtype))
