#!/usr/bin/env python3
"""Generates the meshes of models/ from the measured numbers: objects, arm and gripper; and four toys.

    scripts/make_models.py              rewrites the meshes of this repository
    scripts/make_models.py --out DIR    writes them below DIR instead

All coordinates are whole micrometres, so that the same numbers give the same bytes on every
machine. Every part is a closed surface with outward triangles. Lengths below are metres.
"""

import argparse
import math
import pathlib

import toy_shapes

MICROMETRE = 1e-6

# The water bottle, measured by elliptic slices of a public Kinect scan: height z, half-axes a (wide,
# along x) and b (deep, along y). The slices from .013 to .133 are measured; the base's rounding, the
# collar and the cap, too small for the sensor, are drawn to the measured height and cap radius.
BOTTLE_PROFILE = [
    (0.000, 0.0440, 0.0285),
    (0.002, 0.0459, 0.0300),
    (0.006, 0.0472, 0.0309),
    (0.013, 0.0481, 0.0316),
    (0.023, 0.0494, 0.0336),
    (0.033, 0.0476, 0.0322),
    (0.043, 0.0469, 0.0303),
    (0.053, 0.0488, 0.0285),
    (0.063, 0.0476, 0.0283),
    (0.073, 0.0466, 0.0282),
    (0.083, 0.0486, 0.0290),
    (0.093, 0.0506, 0.0318),
    (0.103, 0.0517, 0.0346),
    (0.113, 0.0457, 0.0351),
    (0.123, 0.0350, 0.0300),
    (0.133, 0.0250, 0.0230),
    (0.141, 0.0195, 0.0190),
    (0.147, 0.0215, 0.0215),
    (0.152, 0.0215, 0.0215),
    (0.158, 0.0180, 0.0180),
    (0.163, 0.0165, 0.0165),
    (0.181, 0.0165, 0.0165),
    (0.183, 0.0150, 0.0150),
]
BOTTLE_SEGMENTS = 48
BOTTLE_RING_STEP = 0.004
# Five convex pieces: fewer lose the waist, many more leave a resting bottle without rest.
BOTTLE_CUTS = [0.000, 0.043, 0.078, 0.113, 0.143, 0.183]
BOTTLE_PIECE_SEGMENTS = 24

AMICELLI_HEIGHT = 0.1425
AMICELLI_ACROSS_FLATS = 0.0855

RUSK_SIZE = (0.148, 0.145, 0.080)


class Mesh:
    """Triangles over vertices in whole micrometres."""

    def __init__(self):
        self.vertices = []
        self.triangles = []

    def add(self, vertices, triangles):
        first = len(self.vertices)
        self.vertices += [tuple(round(c / MICROMETRE) for c in v) for v in vertices]
        self.triangles += [tuple(first + i for i in t) for t in triangles]
        return self

    def write(self, path, comment):
        lines = ["# " + comment, "# Written by scripts/make_models.py; metres."]
        lines += ["v " + " ".join(decimal(c) for c in v) for v in self.vertices]
        lines += ["f " + " ".join(str(i + 1) for i in t) for t in self.triangles]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n", encoding="ascii")


def decimal(micrometres):
    """Micrometres as metres in text, exactly."""
    sign = "-" if micrometres < 0 else ""
    whole, fraction = divmod(abs(micrometres), 10**6)
    return f"{sign}{whole}.{fraction:06d}"


def monotone_cubic(nodes, x):
    """Fritsch-Carlson interpolation of (x, y) nodes: smooth, and no overshoot between them."""
    count = len(nodes)
    steps = [nodes[i + 1][0] - nodes[i][0] for i in range(count - 1)]
    secants = [(nodes[i + 1][1] - nodes[i][1]) / steps[i] for i in range(count - 1)]
    slopes = [secants[0]] + [0.0] * (count - 2) + [secants[-1]]
    for i in range(1, count - 1):
        if secants[i - 1] * secants[i] > 0.0:
            w1 = 2.0 * steps[i] + steps[i - 1]
            w2 = steps[i] + 2.0 * steps[i - 1]
            slopes[i] = (w1 + w2) / (w1 / secants[i - 1] + w2 / secants[i])
    i = max(k for k in range(count - 1) if nodes[k][0] <= x or k == 0)
    t = (x - nodes[i][0]) / steps[i]
    return (nodes[i][1] * (1 + 2 * t) * (1 - t) ** 2 + steps[i] * slopes[i] * t * (1 - t) ** 2
            + nodes[i + 1][1] * t * t * (3 - 2 * t) + steps[i] * slopes[i + 1] * t * t * (t - 1))


def ellipse(a, b, z, segments, phase=0.0):
    angles = [2.0 * math.pi * (k + phase) / segments for k in range(segments)]
    return [(a * math.cos(t), b * math.sin(t), z) for t in angles]


def loft(rings):
    """Closes a stack of rings, each counter-clockwise seen from above, with flat ends."""
    n = len(rings[0])
    vertices = [v for ring in rings for v in ring]
    triangles = []
    for i in range(len(rings) - 1):
        for j in range(n):
            a, b = i * n + j, i * n + (j + 1) % n
            triangles += [(a, b, b + n), (a, b + n, a + n)]
    for ring, upward in ((0, False), (len(rings) - 1, True)):
        centre = len(vertices)
        vertices.append(tuple(sum(v[c] for v in rings[ring]) / n for c in range(3)))
        for j in range(n):
            a, b = ring * n + j, ring * n + (j + 1) % n
            triangles.append((centre, a, b) if upward else (centre, b, a))
    return vertices, triangles


def convex_hull(points):
    """Incremental hull of micrometre points in exact integer arithmetic."""
    points = list(dict.fromkeys(points))

    def minus(p, q):
        return tuple(a - b for a, b in zip(p, q))

    def cross(p, q):
        return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])

    def dot(p, q):
        return sum(a * b for a, b in zip(p, q))

    def height(face, p):
        a, b, c = (points[i] for i in face)
        return dot(cross(minus(b, a), minus(c, a)), minus(p, a))

    # Starts from four points that span a volume.
    corner = [0, 1]
    corner.append(next(i for i in range(2, len(points)) if any(
        cross(minus(points[1], points[0]), minus(points[i], points[0])))))
    corner.append(next(i for i in range(2, len(points)) if height(corner[:3], points[i])))
    a, b, c, d = corner
    if height((a, b, c), points[d]) > 0:
        b, c = c, b
    faces = [(a, b, c), (a, c, d), (c, b, d), (b, a, d)]
    for i, p in enumerate(points):
        visible = {f for f in faces if height(f, p) > 0}
        if not visible:
            continue
        edges = {(f[k], f[(k + 1) % 3]) for f in visible for k in range(3)}
        horizon = [e for e in sorted(edges) if (e[1], e[0]) not in edges]
        faces = [f for f in faces if f not in visible] + [(e[0], e[1], i) for e in horizon]
    used = sorted({i for f in faces for i in f})
    index = {old: new for new, old in enumerate(used)}
    mesh = Mesh()
    mesh.vertices = [points[i] for i in used]
    mesh.triangles = [tuple(index[i] for i in f) for f in faces]
    return mesh


def bottle_axes(z):
    """Half-axes at height z above the base, and z in the model frame: from the box's centre."""
    a = monotone_cubic([(p[0], p[1]) for p in BOTTLE_PROFILE], z)
    b = monotone_cubic([(p[0], p[2]) for p in BOTTLE_PROFILE], z)
    return a, b, z - 0.5 * BOTTLE_PROFILE[-1][0]


def bottle_ring(z):
    return ellipse(*bottle_axes(z), BOTTLE_SEGMENTS)


def bottle_piece_ring(z):
    """A coarse ring drawn round the ellipse, flat towards +-x and +-y: a lying bottle rests on its
    wide face as the smooth one does, not on a corner."""
    a, b, z_model = bottle_axes(z)
    outward = 1.0 / math.cos(math.pi / BOTTLE_PIECE_SEGMENTS)
    return ellipse(outward * a, outward * b, z_model, BOTTLE_PIECE_SEGMENTS, phase=0.5)


def bottle_heights(low, high):
    """The profile's own heights from `low` to `high` and evenly spaced ones between them."""
    nodes = sorted({low, high} | {p[0] for p in BOTTLE_PROFILE if low < p[0] < high})
    heights = []
    for z0, z1 in zip(nodes, nodes[1:]):
        parts = max(1, math.ceil((z1 - z0) / BOTTLE_RING_STEP - 1e-9))
        heights += [z0 + (z1 - z0) * k / parts for k in range(parts)]
    return heights + [nodes[-1]]


def make_bottle(folder):
    heights = bottle_heights(BOTTLE_PROFILE[0][0], BOTTLE_PROFILE[-1][0])
    mesh = Mesh().add(*loft([bottle_ring(z) for z in heights]))
    mesh.write(folder / "bottle.obj", "Water bottle: an oval waisted loft, 0.183 m high")
    for piece, (low, high) in enumerate(zip(BOTTLE_CUTS, BOTTLE_CUTS[1:])):
        points = Mesh()
        for z in bottle_heights(low, high):
            points.add(bottle_piece_ring(z), [])
        convex_hull(points.vertices).write(folder / f"collision_{piece}.obj",
                                           f"Convex piece {piece} of the water bottle")


def make_amicelli(folder):
    corner_radius = AMICELLI_ACROSS_FLATS / math.sqrt(3.0)
    # Corners on +-x, flats towards +-y.
    rings = [ellipse(corner_radius, corner_radius, side * 0.5 * AMICELLI_HEIGHT, 6)
             for side in (-1, 1)]
    Mesh().add(*loft(rings)).write(folder / "amicelli.obj", "Amicelli box: a hexagonal prism")


def make_rusk(folder):
    x, y, z = (0.5 * s for s in RUSK_SIZE)
    rings = [[(-x, -y, s * z), (x, -y, s * z), (x, y, s * z), (-x, y, s * z)] for s in (-1, 1)]
    Mesh().add(*loft(rings)).write(folder / "rusk.obj", "Rusk box: a cuboid, 0.080 m thick along z")


def lathe(profile, segments=32, axis="z", origin=(0.0, 0.0, 0.0)):
    """A solid of revolution from (height, radius) pairs along `axis` through `origin`."""
    rings = [ellipse(radius, radius, height, segments) for height, radius in profile]
    vertices, triangles = loft(rings)
    if axis == "y":  # a cyclic change of axes keeps the orientation
        vertices = [(v[1], v[2], v[0]) for v in vertices]
    return [tuple(c + o for c, o in zip(v, origin)) for v in vertices], triangles


def rounded(low, high, radius_low, radius_high, rounding, steps=5):
    """The profile of a tube from `low` to `high` whose end edges are rounded."""
    arc = [0.5 * math.pi * k / steps for k in range(steps + 1)]
    begin = [(low + rounding * (1 - math.sin(t)), radius_low - rounding * (1 - math.cos(t)))
             for t in reversed(arc)]
    end = [(high - rounding * (1 - math.sin(t)), radius_high - rounding * (1 - math.cos(t)))
           for t in arc]
    return begin + end


def make_arm(folder):
    """Links of a light-weight arm, stretched upward: tubes along z, joint hubs along y."""
    def write(name, *parts):
        mesh = Mesh()
        for part in parts:
            mesh.add(*part)
        mesh.write(folder / f"{name}.obj", f"Own drawing of a light-weight arm: {name}")

    write("base", lathe(rounded(0.0, 0.030, 0.100, 0.095, 0.006)),
          lathe(rounded(0.025, 0.108, 0.078, 0.070, 0.010)))
    # Links 1 and 3 carry the hub of the next joint, which turns about y, 0.2 m up.
    write("link_to_pitch", lathe(rounded(0.004, 0.170, 0.068, 0.056, 0.012)),
          lathe(rounded(-0.058, 0.058, 0.066, 0.066, 0.016), axis="y", origin=(0, 0, 0.2)))
    # Links 2 and 4 start inside that hub and end at a joint about z, 0.2 m up.
    write("link_to_roll", lathe(rounded(0.020, 0.197, 0.056, 0.068, 0.012)))
    write("hub_caps", lathe(rounded(-0.072, 0.072, 0.050, 0.050, 0.010), axis="y"))
    write("ring", lathe(rounded(-0.006, 0.006, 0.0715, 0.0715, 0.003)))
    write("forearm", lathe(rounded(0.004, 0.165, 0.066, 0.050, 0.012)),
          lathe(rounded(-0.048, 0.048, 0.054, 0.054, 0.014), axis="y", origin=(0, 0, 0.19)))
    write("wrist", lathe(rounded(-0.030, 0.046, 0.044, 0.042, 0.012)),
          lathe(rounded(-0.060, 0.060, 0.040, 0.040, 0.010), axis="y"))
    write("flange", lathe(rounded(0.046, 0.078, 0.038, 0.032, 0.004)))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parent.parent / "models",
                        help="folder that gets objects/, lwr/ and toys/ (default: models/)")
    folder = parser.parse_args().out
    make_bottle(folder / "objects" / "bottle")
    make_amicelli(folder / "objects" / "amicelli")
    make_rusk(folder / "objects" / "rusk")
    make_arm(folder / "lwr" / "meshes")
    toy_shapes.make_toys(folder / "toys")


if __name__ == "__main__":
    main()
