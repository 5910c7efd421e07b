"""What is said of a program that has read a file: read, wrong, nothing, crash."""

import numpy as np

# ACEScg to linear Rec.709 by Bradford's transform, as OpenColorIO's built-in configs have it.
TO_REC709 = np.array(
    [
        [1.70505099, -0.62179212, -0.08325887],
        [-0.13025642, 1.14080474, -0.01054832],
        [-0.02400336, -0.12896898, 1.15297233],
    ]
)

# Numbers in other colors are compared to this part of the largest: programs round white points and matrices.
COLOR_TOLERANCE = 5e-3


def stopped(read):
    """The verdict where nothing came back."""
    if read.crash:
        return "crash", read.crash
    if read.refusal:
        return "nothing", read.refusal
    if not read.planes:
        return "nothing", ""
    return None


def same(a, b):
    """Whether numbers are the same, up to the rounding of a division by alpha and back."""
    return a.shape == b.shape and np.allclose(a, b, rtol=1e-5, atol=1e-6, equal_nan=True)


def rgb(planes):
    """R, G and B as rows of triples, or None."""
    return np.stack([planes[name] for name in "RGB"], -1) if all(name in planes for name in "RGB") else None


def picture(image, read):
    """R, G, B and A are those of the file."""
    if verdict := stopped(read):
        return verdict
    missing = [name for name in "RGBA" if name not in read.planes]
    if "R" in missing or "G" in missing or "B" in missing:
        return "nothing", f"has {', '.join(read.planes)}"
    wrong = [name for name in "RGBA" if name in read.planes and not same(image.planes[name], read.planes[name])]
    if wrong:
        if image.planes["R"].shape != read.planes["R"].shape:
            return "wrong", f"size {read.said['size']}"
        off = max(np.max(np.abs(image.planes[name] - read.planes[name])) for name in wrong)
        return "wrong", f"{', '.join(wrong)} off by {off:.3g}"
    return "read", "without A" if missing else ""


def space(image, read):
    """Whether a picture in ACEScg is shown as what it is, or what tells so is handed on."""
    if verdict := stopped(read):
        return verdict
    seen, as_stored = rgb(read.planes), rgb(image.planes)
    if seen is None or seen.shape != as_stored.shape:
        return "nothing", ""
    converted = as_stored @ TO_REC709.T
    limit = COLOR_TOLERANCE * np.max(np.abs(as_stored))
    if np.max(np.abs(seen - converted)) < limit:
        return "read", "converted to Rec.709"
    if np.max(np.abs(seen - as_stored)) < limit:
        told = ", ".join(read.said["tags"])
        if read.said["color"] == "stored" and told:
            return "read", f"tells {told}"
        return "wrong", "taken for Rec.709" if read.said["color"] == "rec709" else "numbers as stored; does not tell the space"
    return "wrong", f"off by {np.max(np.abs(seen - converted)):.3g} from Rec.709, {np.max(np.abs(seen - as_stored)):.3g} from the numbers as stored"


def place(image, read):
    """Whether the part is where it is in the whole image."""
    if verdict := stopped(read):
        return verdict
    seen = rgb(read.planes)
    if seen is None:
        return "nothing", ""
    width, height = image.whole
    truth = np.zeros((height, width, 3), np.float32)
    x, y = image.place
    part = rgb(image.planes)
    truth[y : y + part.shape[0], x : x + part.shape[1]] = part
    if read.said["place"] is not None and read.said["whole"] == [width, height] and seen.shape != truth.shape:
        placed = np.zeros_like(truth)
        x, y = read.said["place"]
        placed[y : y + seen.shape[0], x : x + seen.shape[1]] = seen
        seen = placed
    if same(seen, truth):
        return "read", ""
    if same(seen, part):
        return "wrong", "the part alone, without its place"
    for y in range(height - part.shape[0] + 1):
        for x in range(width - part.shape[1] + 1):
            if seen.shape == truth.shape and same(seen[y : y + part.shape[0], x : x + part.shape[1]], part):
                return "wrong", f"at {x}, {y} instead of {image.place[0]}, {image.place[1]}"
    return "wrong", f"size {read.said['size']}"


def layers(image, read):
    """Which channels have come over, by name and value."""
    verdict, remark = picture(image, read)
    if verdict != "read":
        return verdict, remark
    names = [name for name in image.planes if name not in "RGBA"]
    missing = [name for name in names if name not in read.planes]
    wrong = [name for name in names if name in read.planes and not same(image.planes[name], read.planes[name])]
    groups = sorted({name.rpartition(".")[0] or name for name in missing})
    remark = f"{len(names) - len(missing) - len(wrong)} of {len(names)} channels"
    if wrong:
        return "wrong", f"{remark}; wrong: {', '.join(wrong[:6])}"
    if len(missing) == len(names):
        return "picture", "and no layer"
    if missing:
        return "part", f"{remark}; not {', '.join(groups[:8])}"
    return "read", ""


VERDICTS = {"picture": picture, "space": space, "place": place, "layers": layers}
