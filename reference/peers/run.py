#!/usr/bin/env python3
"""Renders a scene with other programs, as fast as each can: times and pictures for `candela report --peers`.

    reference/peers/run.py scene.toml -o peers/peers.json
    candela report scene.toml -o report --peers peers/peers.json

README.md beside this file says what each program needs, and how it is asked.
"""

import argparse
import importlib
import json
import os
import statistics
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "conformance"))

from described import Refused, described  # noqa: E402

PEERS = ["embree", "mitsuba", "povray"]

# A setting that has taken so many seconds is not rendered again, and none that is slower comes after it.
PATIENCE = 30.0


def legible(path):
    """What a scene says, if the translators understand all of it."""
    scene = tomllib.loads(path.read_text())
    image = scene["image"]
    if image.get("color_space", "rec709") != "rec709":
        raise Refused("a working space other than Rec.709")
    if image.get("transport", "auto") == "spectral":
        raise Refused("light that is carried spectrally")
    kinds = [
        ("lights", "point", "spot"),
        ("materials", "phong", "normalized_phong"),
        ("objects", "sphere", "plane", "triangle", "mesh"),
        ("camera", "perspective", "orthographic"),
    ]
    for section, *known in kinds:
        entries = scene[section].values() if section != "camera" else [scene[section]]
        for kind, keys in (next(iter(entry.items())) for entry in entries):
            if kind not in known:
                raise Refused(f"{kind} of {section}")
            if keys.get("shadow_terminator", "geometric") != "geometric" or not keys.get("smooth", True):
                raise Refused("meshes that do not take their normals as they are")
    return described(scene, path.parent)


def measured(peer, scene, options, folder):
    """A row for each setting of a program."""
    rows = []
    for setting in peer.settings(scene, options):
        seconds = []
        while len(seconds) < options.runs and sum(seconds) < PATIENCE:
            seconds.append(peer.render(setting))
        picture = f"{folder.stem}-{peer.NAME}-{len(rows) + 1}.exr"
        peer.save(setting, folder.parent / picture)
        taken = statistics.median(seconds)
        rows.append(
            {
                "series": setting.series,
                "setting": setting.name,
                "label": setting.label,
                "samples_per_pixel": setting.samples,
                "seconds": taken,
                "runs": len(seconds),
                "picture": picture,
            }
        )
        print(f"{setting.series:24} {setting.name:24} {taken:9.4f} s", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, help="the JSON; pictures go beside it")
    parser.add_argument("--peer", action="append", choices=PEERS, help="one of them; all without")
    parser.add_argument("--samples", default="1,4,16,64", help="of Embree and Mitsuba (1,4,16,64)")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--runs", type=int, default=3, help="of which the median counts (3)")
    options = parser.parse_args()
    options.samples = [int(count) for count in options.samples.split(",")]
    options.patience = PATIENCE
    options.output.parent.mkdir(parents=True, exist_ok=True)
    found = {"threads": options.threads, "rows": [], "left_out": [], "remarks": []}
    for name in options.peer or PEERS:
        module = importlib.import_module(f"peer_{name}")
        try:
            with module.Peer(legible(options.scene), options) as peer:
                found["rows"] += measured(peer, peer.scene, options, options.output)
                found["remarks"] += peer.remarks
        except Refused as reason:
            found["left_out"].append({"what": module.Peer.TITLE, "why": f"it, or its translator, cannot express {reason}"})
        except module.Missing as reason:
            found["left_out"].append({"what": module.Peer.TITLE, "why": str(reason)})
    for left_out in found["left_out"]:
        print(f"left out: {left_out['what']}: {left_out['why']}")
    options.output.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
