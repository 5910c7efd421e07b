#!/usr/bin/env python3
"""Writes the outlines of the characters that drawings use: src/cli/drawing/glyphs.txt, from DejaVu Sans.

    docs/glyphs.py DejaVuSans.ttf      (with a Python that has `fonttools`)

A line is a character, its advance width and its outline as the path of an SVG, in 2048ths of the font size with y up.
"""

import sys
from pathlib import Path

from fontTools.pens.svgPathPen import SVGPathPen
from fontTools.ttLib import TTFont

HERE = Path(__file__).resolve().parent
OUT = HERE.parent / "src/cli/drawing/glyphs.txt"
CHARACTERS = [chr(code) for code in range(32, 127)] + list("²³·×°±µεΔΣᵢ−–—…≤≥≈√∝→□äöüéÄÖÜ")

font = TTFont(sys.argv[1])
names, glyphs = font.getBestCmap(), font.getGlyphSet()
head = [line for line in OUT.read_text().splitlines(True) if line.startswith("#")] if OUT.exists() else []
lines = []
for character in CHARACTERS:
    name = names[ord(character)]
    pen = SVGPathPen(glyphs, ntos=lambda number: f"{round(number)}")
    glyphs[name].draw(pen)
    lines.append(f"{ord(character):04X} {glyphs[name].width} {pen.getCommands()}\n")
OUT.write_text("".join(head + lines))
