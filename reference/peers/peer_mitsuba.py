"""Mitsuba 3, `llvm_ad_rgb`: for each light a render of its own, since it draws one light at random for a sample."""

import ctypes.util
import glob
import os
import re
import time

import exr
from peer import Missing, setting, without_planes
from renderer_mitsuba import dark, emitters

# The more lanes a render has, the more memory it takes: so many samples are rendered at once.
AT_ONCE = 2**27


def modules():
    """mitsuba as `llvm_ad_rgb`, drjit and numpy."""
    library = newest_llvm()
    if library is None:
        raise Missing("LLVM's library is not there (Debian: libllvm19)")
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)
    try:
        import drjit
        import mitsuba
        import numpy
    except ImportError:
        raise Missing("the Python packages mitsuba and numpy are not there") from None
    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba, drjit, numpy


class Peer:
    NAME, TITLE = "mitsuba", "Mitsuba 3"

    def __init__(self, scene, options):
        mitsuba, drjit, numpy = modules()
        drjit.set_thread_count(options.threads)
        self.mi, self.dr, self.np = mitsuba, drjit, numpy
        has_planes = any(object_.kind == "plane" for object_ in scene.objects)
        self.scene = without_planes(scene)
        base = dark(mitsuba, numpy, self.scene, {"type": "multijitter", "sample_count": 1})
        self.scenes = [mitsuba.load_dict(base | {"light": light}) for light in emitters(mitsuba, self.scene)]
        self.series = f"Mitsuba {mitsuba.__version__}"
        self.picture, self.warm = None, None
        self.remarks = [
            f"Mitsuba {mitsuba.__version__}: llvm_ad_rgb, direct integrator, multijitter sampler, a render for each light, all added; "
            "its kernels are compiled before the clock starts" + ("; a plane is a large square" if has_planes else "")
        ]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def settings(self, scene, options):
        for count in options.samples:
            if count * scene.width * scene.height <= AT_ONCE:
                name = "1 sample" if count == 1 else f"{count} samples"
                yield setting(self.series, name, str(count), count)

    def render(self, setting):
        if self.warm != setting.samples:
            # The kernel of this size.
            self.sum(setting.samples, 0)
            self.warm = setting.samples
        start = time.perf_counter()
        self.picture = self.sum(setting.samples, 1)
        return time.perf_counter() - start

    def sum(self, samples, seed):
        total = None
        for number, scene in enumerate(self.scenes):
            picture = self.mi.render(scene, spp=samples, seed=seed * len(self.scenes) + number)
            total = picture if total is None else total + picture
        self.dr.eval(total)
        self.dr.sync_thread()
        return total

    def save(self, setting, path):
        values = self.np.array(self.picture, dtype=self.np.float32).reshape(-1, 3)
        channels = {channel: values[:, i].tolist() for i, channel in enumerate("RGB")}
        exr.write(path, self.scene.width, self.scene.height, channels)


def newest_llvm():
    """The library of the newest LLVM that Debian's packages have put somewhere."""
    found = glob.glob("/usr/lib/*/libLLVM*.so*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*")
    version = lambda path: [int(number) for number in re.findall(r"\d+", os.path.basename(path))][:1]
    return max(found, key=version, default=None) or ctypes.util.find_library("LLVM")
