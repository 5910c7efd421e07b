"""Mitsuba 3, `scalar_rgb`: point lights and spots on Lambertian surfaces; it has no Phong lobe.

It draws one light at random for a sample: each light is rendered by itself, and the pictures are summed.
"""

from math import pi

from described import Refused, rays
from vectors import add, at, cross, dot, length, meets_plane, mul, sub, unit


def render(scene, program, peak):
    import mitsuba as mi
    import numpy as np

    mi.set_variant("scalar_rgb")
    sampler = {"type": "stratified", "sample_count": 1, "jitter": False}
    total = 0
    for light in emitters(mi, scene):
        described = dark(mi, np, scene, sampler) | {"light": light}
        total = total + np.array(mi.render(mi.load_dict(described), spp=1), dtype=np.float64)
    return {channel: total[:, :, i].ravel().tolist() for i, channel in enumerate("RGB")}


def matt(material):
    if any(material.specular):
        raise Refused("a specular lobe")
    k = mul(material.diffuse, 1 / pi) if material.model == "normalized_phong" else material.diffuse
    return {
        "type": "twosided",
        # Its reflectance ρ is ρ/π of light: the lights are π times as strong.
        "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": k}},
    }


def dark(mi, np, scene, sampler, bsdf=matt):
    """The scene without its lights, as a dictionary; `bsdf` says a material in Mitsuba's words."""
    transform = mi.ScalarTransform4f
    if any(scene.background):
        raise Refused("a background that does not light")
    seen = scene.camera
    world = transform().look_at(origin=seen.eye, target=seen.look_at, up=seen.up)
    sensor = {
        "type": seen.kind,
        "film": {
            "type": "hdrfilm", "width": scene.width, "height": scene.height,
            "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32",
        },
        "sampler": sampler,
    }
    extent = max(length(sub(seen.eye, seen.look_at)), *[length(sub(l.position, seen.look_at)) for l in scene.lights], 0)
    if seen.kind == "perspective":
        sensor |= {"fov": seen.size, "fov_axis": "y", "to_world": world, "near_clip": 1e-4 * extent, "far_clip": 1e6 * extent}
    else:
        half = seen.size / 2
        # Its image is two units wide.
        wide = half * scene.width / scene.height
        sensor |= {"to_world": world @ transform().scale([wide, wide, 1]), "near_clip": 1e-4 * extent, "far_clip": 1e6 * extent}
    described = {"type": "scene", "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}, "sensor": sensor}
    for name, material in scene.materials.items():
        described[f"bsdf_{name}"] = bsdf(material)
    for number, object_ in enumerate(scene.objects):
        for part, shape in enumerate(shapes(mi, np, object_, scene, extent)):
            described[f"shape_{number}_{part}"] = shape | {"bsdf": {"type": "ref", "id": f"bsdf_{object_.material}"}}
    return described


def emitters(mi, scene):
    """Each light, as a dictionary."""
    for light in scene.lights:
        strength = {"type": "rgb", "value": mul(light.intensity, pi)}
        if light.kind == "point":
            yield {"type": "point", "position": light.position, "intensity": strength}
        elif light.falloff == "linear_angle":
            axis = unit(sub(light.look_at, light.position))
            aside = unit(cross(axis, [1, 0, 0] if abs(axis[0]) < 0.9 else [0, 1, 0]))
            yield {
                "type": "spot", "intensity": strength,
                "beam_width": light.inner, "cutoff_angle": light.outer,
                "to_world": mi.ScalarTransform4f().look_at(origin=light.position, target=light.look_at, up=aside),
            }
        else:
            raise Refused(f"the falloff {light.falloff}")


def shapes(mi, np, object_, scene, extent):
    transform = mi.ScalarTransform4f
    if object_.kind == "sphere":
        yield {"type": "sphere", "center": object_.center, "radius": object_.radius}
    elif object_.kind == "plane":
        # A square as large as what is seen of it and no larger, since it takes points as parts of that.
        n = object_.normal
        foot = at(scene.camera.look_at, n, dot(sub(object_.point, scene.camera.look_at), n))
        seen = []
        for ray in rays(scene):
            t = meets_plane(*ray, object_.point, n)
            # Behind another plane nothing of it is seen.
            before = [meets_plane(*ray, other.point, other.normal) for other in scene.objects if other.kind == "plane"]
            if t is not None and t == min(hit for hit in before if hit is not None):
                seen.append(length(sub(at(*ray, t), foot)))
        half = 1.01 * max(seen + [extent])
        aside = unit(cross(n, [1, 0, 0] if abs(n[0]) < 0.9 else [0, 1, 0]))
        world = transform().look_at(origin=foot, target=add(foot, n), up=aside)
        yield {"type": "rectangle", "to_world": world @ transform().scale([half] * 3)}
    else:
        for is_smooth in (False, True):
            part = [(c, n) for c, n in object_.triangles if (n is not None) == is_smooth]
            if not part:
                continue
            mesh = mi.Mesh("mesh", 3 * len(part), len(part), has_vertex_normals=is_smooth)
            parameters = mi.traverse(mesh)
            parameters["vertex_positions"] = np.ravel([c for c, _ in part]).astype(np.float32)
            parameters["faces"] = np.arange(3 * len(part), dtype=np.uint32)
            if is_smooth:
                parameters["vertex_normals"] = np.ravel([n for _, n in part]).astype(np.float32)
            parameters.update()
            yield {"type": "ply", "filename": write_ply(mesh), "face_normals": not is_smooth}


def write_ply(mesh):
    import atexit
    import os
    import tempfile

    handle, path = tempfile.mkstemp(suffix=".ply")
    os.close(handle)
    atexit.register(os.unlink, path)
    mesh.write_ply(path)
    return path
