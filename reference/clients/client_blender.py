"""Blender by its Python package (PyPI: bpy): each output of the compositor's Image node, written by a File Output node.

Where the whole image is larger than what is read, it is asked for in the size of the whole image, so that the place
counts."""

import sys
import tempfile
import warnings
from pathlib import Path

from handed import arguments, hand_back, not_here

try:
    import bpy
except ImportError as error:
    not_here(error)

import numpy as np

OLD = bpy.app.version < (5, 0, 0)


def compositor(scene):
    """The tree of the scene's compositor, empty."""
    if OLD:
        scene.use_nodes = True
        tree = scene.node_tree
        for node in list(tree.nodes):
            tree.nodes.remove(node)
    else:
        tree = bpy.data.node_groups.new("clients", "CompositorNodeTree")
        scene.compositing_node_group = tree
    return tree


def composed(scene, tree, sockets, folder):
    """What sockets give, by their index: a file of 32 bits each, read by Blender again as plain data."""
    scene.render.compositor_device = "CPU"
    scene.render.use_compositing = True
    for index, socket in enumerate(sockets):
        node = tree.nodes.new("CompositorNodeOutputFile")
        if OLD:
            node.base_path = str(folder)
            node.format.file_format, node.format.color_mode = "OPEN_EXR", "RGBA"
            node.format.color_depth, node.format.exr_codec = "32", "NONE"
            node.file_slots[0].path = f"{index}_"
            tree.links.new(socket, node.inputs[0])
        else:
            node.directory, node.file_name = str(folder), f"{index}_"
            node.format.media_type = "IMAGE"
            node.format.file_format, node.format.color_mode = "OPEN_EXR", "RGBA"
            node.format.color_depth, node.format.exr_codec = "32", "NONE"
            node.file_output_items.new("RGBA", "")
            tree.links.new(socket, node.inputs[0])
    bpy.ops.render.render()
    planes = {}
    for index in range(len(sockets)):
        (written,) = folder.glob(f"{index}_*.exr")
        image = bpy.data.images.load(str(written))
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        # Rows start at the bottom. Sockets of one or three numbers fill up to four.
        planes[index] = pixels.reshape(height, width, 4)[::-1]
    return planes


def main():
    warnings.simplefilter("ignore")
    path, out, _ = arguments()
    scene = bpy.context.scene
    image = bpy.data.images.load(str(path))
    tree = compositor(scene)
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    scene.render.resolution_percentage = 100
    scene.render.resolution_x, scene.render.resolution_y = map(int, sys.argv[4].split("x"))
    sockets = [socket for socket in node.outputs if socket.enabled]
    with tempfile.TemporaryDirectory() as folder:
        read = composed(scene, tree, sockets, Path(folder))
    planes = {}
    for index, socket in enumerate(sockets):
        pixels = read[index]
        height, width = pixels.shape[:2]
        if socket.name in ("Combined", "Image"):
            names = "RGBA"
        elif socket.type == "VALUE":
            names = ""
        elif socket.name.startswith("Crypto"):
            names = "RGBA"
        else:
            names = "XYZ" if socket.type == "VECTOR" else "RGB"
        prefix = "" if socket.name in ("Combined", "Image") else f"{socket.name}."
        # An output named as a channel would be, with what the socket's type has of R, G, B.
        planes |= {f"{prefix}{letter}": pixels[:, :, i] for i, letter in enumerate(names)}
        if not names:
            planes[{"Depth": "Z", "Alpha": "the node's alpha"}.get(socket.name, socket.name)] = pixels[:, :, 0]
    version = ".".join(map(str, bpy.app.version))
    hand_back(out, f"Blender {version}", planes, color="rec709", place=[0, 0], whole=[width, height])


main()
