"""Vectors of three numbers, and where rays meet shapes."""

from math import sqrt


def add(a, b):
    return [x + y for x, y in zip(a, b)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def mul(a, factor):
    return [x * factor for x in a]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def length(a):
    return sqrt(dot(a, a))


def unit(a):
    return mul(a, 1 / length(a))


def at(origin, direction, t):
    return add(origin, mul(direction, t))


def meets_plane(origin, direction, point, normal):
    """t of o + t ω, or None."""
    across = dot(direction, normal)
    if across == 0:
        return None
    t = dot(sub(point, origin), normal) / across
    return t if t > 0 else None


def meets_sphere(origin, direction, center, radius):
    """The nearest t > 0 of o + t ω, or None; ω is a unit vector."""
    way = sub(center, origin)
    middle = dot(way, direction)
    aside = sub(way, mul(direction, middle))
    rest = radius * radius - dot(aside, aside)
    if rest < 0:
        return None
    # Of the two roots of t² − 2 b t + c the one that loses no digits, then the other by their product.
    inner = dot(way, way) - radius * radius
    far = middle + sqrt(rest) if middle > 0 else middle - sqrt(rest)
    roots = sorted([far, inner / far])
    return next((t for t in roots if t > 0), None)


def barycentric(p, corners):
    """Of p in the plane of the triangle."""
    a, b, c = corners
    normal = cross(sub(b, a), sub(c, a))
    area = dot(normal, normal)
    return [
        dot(normal, cross(sub(c, b), sub(p, b))) / area,
        dot(normal, cross(sub(a, c), sub(p, c))) / area,
        dot(normal, cross(sub(b, a), sub(p, a))) / area,
    ]


def meets_triangle(origin, direction, corners):
    normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]))
    t = meets_plane(origin, direction, corners[0], normal)
    if t is None or min(barycentric(at(origin, direction, t), corners)) < 0:
        return None
    return t
