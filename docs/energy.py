#!/usr/bin/env python3
"""Draws docs/pictures/energy.svg: curves by the closed form of docs/energy.md, points from what candela renders.

    cargo build --release && docs/energy.py [CANDELA]
"""

import subprocess
import sys
import tempfile
from math import cos, exp, lgamma, pi, radians, sin, sqrt
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "reference" / "conformance"))
sys.dont_write_bytecode = True
import exr  # noqa: E402

EXPONENTS = [1, 5, 20, 100, 1000]
COLORS = ["#7b3294", "#2c7bb6", "#1a9641", "#e08214", "#d7191c"]
MEASURED = [2, 15, 30, 45, 60, 70, 80, 85]
ROWS, COLUMNS = 24, 96


def wallis(m):
    return sqrt(pi) / 2 * exp(lgamma((m + 1) / 2) - lgamma(m / 2 + 1))


def lobe_with_cosine(theta, n):
    s, c, m = sin(theta), cos(theta), n + 2
    a = s**m * wallis(m)
    term, b, exponent = a, 0.0, m
    while term > 1e-12 * (1 + b):
        b += term
        term *= s * s * (exponent + 1) / (exponent + 2)
        exponent += 2
    return 2 * pi * c / m + 2 * a / (n + 1) - 2 * c * c * b / m


def phong(theta, n):
    return lobe_with_cosine(theta, n) / cos(theta)


def normalized(theta, n):
    return lobe_with_cosine(theta, n) * (n + 2) / (2 * pi)


def rendered(candela, model, theta, n):
    """What lights of all directions around the mirrored view send to the viewer, as in tests/energy.rs."""
    s, c = sin(theta), cos(theta)
    parts = [
        "[image]\nresolution = [1, 1]\n[camera.orthographic]\n"
        f"eye = [{s!r}, {c!r}, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nheight = 1e-6\n"
        f"[materials.m.{model}]\nspecular = 1\nshininess = {n}\n"
        '[objects.floor.plane]\nmaterial = "m"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n'
    ]
    for row in range(ROWS):
        x = ((row + 0.5) / ROWS) ** (1 / (n + 1))
        aside = sqrt(1 - x * x)
        weight = 2 * pi / COLUMNS / ROWS / ((n + 1) * x**n)
        for column in range(COLUMNS):
            angle = 2 * pi * (column + 0.5) / COLUMNS
            way = [c * aside * cos(angle) - s * x, s * aside * cos(angle) + c * x, aside * sin(angle)]
            if way[1] > 0:
                strength = weight * (way[1] / c if model == "phong" else 1)
                parts.append(f"[lights.l{row}-{column}.point]\nposition = {way}\nintensity = {strength!r}\n")
    with tempfile.TemporaryDirectory() as folder:
        scene, out = Path(folder) / "scene.toml", Path(folder) / "out.exr"
        scene.write_text("\n".join(parts))
        subprocess.run([candela, "render", scene, "--samples", "1", "-o", out, "--quiet"], check=True)
        return exr.read(out)[2]["G"][0]


WIDTH, HEIGHT, TOP = 330, 260, 40


def panel(left, title, model, of, candela, most):
    x = lambda degrees: left + WIDTH * degrees / 90
    y = lambda value: TOP + HEIGHT * (1 - value / most)
    lines = [
        f'<text x="{left}" y="{TOP - 14}" font-weight="bold">{title}</text>',
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
    ]
    for degrees in range(0, 91, 30):
        lines.append(f'<text x="{x(degrees):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{degrees}°</text>')
    for tick in range(5):
        value = most * tick / 4
        lines.append(f'<path d="M{left} {y(value):.1f}h{WIDTH}" stroke="#ddd"/>')
        lines.append(f'<text x="{left - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:g}</text>')
    lines.append(f'<path d="M{left} {y(1):.1f}h{WIDTH}" stroke="#444" stroke-dasharray="4 3"/>')
    for n, color in zip(EXPONENTS, COLORS):
        points = [(d / 2, of(radians(d / 2), n)) for d in range(0, 180)]
        inside = [(d, v) for d, v in points if v <= most]
        path = "L".join(f"{x(d):.1f} {y(v):.1f}" for d, v in inside)
        lines.append(f'<path d="M{path}" fill="none" stroke="{color}" stroke-width="1.5"/>')
        for degrees in MEASURED:
            value = rendered(candela, model, radians(degrees), n)
            if value <= most:
                lines.append(f'<circle cx="{x(degrees):.1f}" cy="{y(value):.1f}" r="2.5" fill="{color}"/>')
    return lines


def main():
    candela = sys.argv[1] if len(sys.argv) > 1 else ROOT / "target" / "release" / "candela"
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" width="820" height="350" font-family="sans-serif" font-size="12">',
        '<rect width="820" height="350" fill="#fff"/>',
    ]
    lines += panel(50, "phong, specular = 1", "phong", phong, candela, 4.0)
    lines += panel(440, "normalized_phong, specular = 1", "normalized_phong", normalized, candela, 1.0)
    for index, (n, color) in enumerate(zip(EXPONENTS, COLORS)):
        at = 50 + 90 * index
        lines.append(f'<path d="M{at} 335h20" stroke="{color}" stroke-width="2"/><text x="{at + 26}" y="339">n = {n}</text>')
    lines.append('<text x="520" y="339">lines: closed form, points: rendered</text></svg>')
    (ROOT / "docs" / "pictures" / "energy.svg").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
