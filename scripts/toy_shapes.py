"""Four free-form toys: smooth, asymmetric figures without flat faces, for the recognizer's tests.

A toy is a sum of limbs. A limb is a ball rolled along a polyline while its radius changes; all pieces
melt into each other by a smooth union of their distance functions. The surface is meshed by marching
tetrahedra, its triangles are evened out and drawn back onto the surface along the gradient. Only
+, -, *, / and square roots are used, so that the same numbers give the same bytes on every machine.
Lengths in the tables are millimetres.
"""

import itertools
import math
import struct

# name: (scale, grid cell, melting width, limbs). A limb is a list of (x, y, z, radius): x forward,
# y to the left, z up. Sizes and poses are free inventions; heads are turned, tails bent and no two
# limbs alike, so that no pose looks like another one.
TOYS = {
    "ram": (1.05, 5.7, 9.0, [
        [(-38, 0, 62, 27), (30, 2, 66, 23)],                                       # body
        [(-10, 4, 78, 21), (18, -2, 80, 20)],                                      # wool
        [(33, 3, 74, 17), (52, 10, 98, 14)],                                       # neck
        [(52, 10, 100, 14), (76, 20, 90, 8.5)],                                    # head
        [(50, 20, 108, 8), (36, 34, 114, 7), (26, 42, 102, 5.5), (34, 48, 86, 5)],
        [(54, -1, 110, 8), (46, -16, 119, 7), (34, -24, 112, 5.5), (34, -31, 96, 5)],
        [(27, 12, 48, 11), (32, 15, 24, 8.5), (34, 15, 8, 8)],                     # legs
        [(27, -11, 48, 11), (48, -16, 34, 8.5), (46, -15, 14, 7.5)],               # raised
        [(-34, 13, 48, 13), (-44, 15, 26, 9), (-40, 16, 8, 8)],
        [(-32, -13, 48, 13), (-26, -17, 26, 9), (-29, -17, 8, 8)],
        [(-60, 0, 70, 7), (-76, -9, 60, 6)],                                       # tail
    ]),
    "goose": (0.88, 4.8, 9.0, [
        [(-38, 0, 46, 28), (24, 0, 52, 23)],                                       # body
        [(-58, -2, 54, 16), (-92, -8, 70, 7)],                                     # tail
        [(36, 0, 62, 15), (55, 6, 88, 11), (49, 10, 116, 9), (60, 14, 138, 11)],   # neck
        [(60, 14, 138, 13), (68, 17, 139, 11)],                                    # head
        [(74, 19, 135, 8), (94, 28, 129, 5.5)],                                    # beak
        [(-4, 17, 62, 14), (-22, 50, 82, 10), (-48, 72, 96, 6)],                   # raised wing
        [(12, -20, 58, 13), (-18, -30, 54, 12), (-52, -31, 48, 7)],                # folded wing
        [(2, 12, 26, 9), (6, 14, 9, 6.5), (24, 20, 6, 6)],                         # feet
        [(-12, -12, 26, 9), (-14, -15, 9, 6.5), (2, -26, 6, 6)],
    ]),
    "stego": (0.86, 5.0, 8.0, [
        [(-45, 0, 54, 27), (8, 0, 62, 29), (44, 6, 48, 20)],                       # trunk
        [(44, 6, 48, 18), (70, 16, 35, 12), (92, 27, 28, 7.5)],                    # head
        [(-60, 0, 52, 18), (-98, -14, 48, 10), (-130, -40, 60, 6)],              # tail
        [(-102, -16, 52, 7), (-112, -14, 84, 5)],                                  # spikes
        [(-104, -18, 52, 7), (-106, -52, 68, 5)],
        [(34, 9, 64, 8), (33, 14, 88, 5)],                                         # plates
        [(12, -6, 86, 10), (8, -12, 113, 5.5)],
        [(-14, 5, 84, 10), (-20, 12, 114, 5.5)],
        [(-42, -5, 76, 9), (-50, -10, 100, 5)],
        [(-70, 2, 60, 8), (-80, 6, 82, 5)],
        [(34, 19, 36, 11), (42, 24, 10, 9)],                                       # legs
        [(28, -16, 40, 11), (22, -24, 10, 9)],
        [(-44, 18, 36, 13), (-54, 23, 11, 10)],
        [(-40, -18, 36, 13), (-34, -24, 11, 10)],
    ]),
    "gnome": (0.95, 5.0, 8.0, [
        [(0, 0, 36, 32), (0, 0, 70, 24)],                                          # body
        [(2, 0, 100, 20)],                                                         # head
        [(-1, 0, 114, 20), (-8, 6, 140, 11), (-24, 16, 158, 5)],                   # hat
        [(21, 2, 99, 6), (28, 3, 97, 5.5)],                                        # nose
        [(16, 0, 88, 12), (29, -3, 62, 5)],                                        # beard
        [(0, 24, 74, 11), (8, 46, 88, 9), (14, 54, 112, 9)],                       # raised arm
        [(14, 54, 114, 12)],                                                       # apple
        [(0, -24, 72, 11), (6, -46, 56, 9), (26, -32, 44, 9)],                     # arm on the hip
        [(2, 14, 12, 14), (30, 19, 9, 10)],                                        # boots
        [(-2, -14, 12, 14), (22, -26, 9, 10)],
        [(-26, -8, 66, 14), (-38, -14, 44, 22)],                                   # sack
    ]),
}

BLOCK = 4  # cells per side of the blocks that are skipped when far from the surface
RELAXATIONS = 3
MICROMETRES_PER_MILLIMETRE = 1000


def segments_of(limbs):
    """(start, direction, 1 / squared length, radius, growth) for every piece of every limb."""
    segments = []
    for nodes in limbs:
        for p, q in zip(nodes, nodes[1:] or nodes):
            d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
            length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
            segments.append((*p[:3], *d, 1.0 / length2 if length2 > 0 else 0.0, p[3], q[3] - p[3]))
    return segments


def make_field(limbs, melt):
    """The distance to the toy's surface, near enough to a true distance; negative inside."""
    segments = segments_of(limbs)
    sqrt = math.sqrt

    def field(x, y, z):
        total = 1e9
        for ax, ay, az, dx, dy, dz, inverse, radius, growth in segments:
            rx, ry, rz = x - ax, y - ay, z - az
            t = (rx * dx + ry * dy + rz * dz) * inverse
            t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
            ex, ey, ez = rx - t * dx, ry - t * dy, rz - t * dz
            distance = sqrt(ex * ex + ey * ey + ez * ez) - radius - t * growth
            overlap = melt - abs(total - distance)
            total = distance if distance < total else total
            if overlap > 0.0:
                total -= overlap * overlap / (4.0 * melt)
        return total

    return field


def sample_grid(field, limbs, cell):
    """Field values at the grid points near the surface: {(i, j, k): value}, and the grid's origin.

    The field changes by at most its argument's length (limbs taper gently), so a block whose centre
    is further from the surface than its corners are from it holds no surface.
    """
    low, high = [[pick(node[axis] + sign * node[3] for limb in limbs for node in limb)
                  for axis in range(3)] for pick, sign in ((min, -1), (max, 1))]
    origin = [v - 3 * cell for v in low]
    blocks = [int((h - o) / (cell * BLOCK)) + 2 for h, o in zip(high, origin)]
    reach = 1.3 * 0.5 * BLOCK * cell * math.sqrt(3.0)
    values = {}
    for bi in range(blocks[0]):
        for bj in range(blocks[1]):
            for bk in range(blocks[2]):
                centre = [o + (b + 0.5) * BLOCK * cell for o, b in zip(origin, (bi, bj, bk))]
                if abs(field(*centre)) > reach:
                    continue
                for i in range(bi * BLOCK, (bi + 1) * BLOCK + 1):
                    for j in range(bj * BLOCK, (bj + 1) * BLOCK + 1):
                        for k in range(bk * BLOCK, (bk + 1) * BLOCK + 1):
                            if (i, j, k) not in values:
                                values[i, j, k] = field(origin[0] + i * cell, origin[1] + j * cell,
                                                        origin[2] + k * cell)
    return values, origin


def parity(order):
    """+1 for an even permutation of 0 .. n-1, -1 for an odd one."""
    return (-1) ** sum(order[a] > order[b] for a in range(len(order)) for b in range(a, len(order)))


def cell_tetrahedra():
    """The six tetrahedra that share a cube's long diagonal, each positively oriented.

    Neighbouring cubes cut their common face along the same diagonal, so the surface has no gaps.
    """
    tetrahedra = []
    for axes in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        corners = [(0, 0, 0)]
        for axis in axes:
            corners.append(tuple(c + (k == axis) for k, c in enumerate(corners[-1])))
        if parity(axes) < 0:
            corners[0], corners[1] = corners[1], corners[0]
        tetrahedra.append(corners)
    return tetrahedra


def cut(inside):
    """The outward polygon in which the surface cuts a tetrahedron: edges (inner, outer corner)."""
    inner = [c for c in range(4) if inside[c]]
    order = inner + [c for c in range(4) if not inside[c]]
    if parity(order) < 0:
        p, q = (0, 1) if len(inner) == 3 else (2, 3)  # two that lie on the same side
        order[p], order[q] = order[q], order[p]
    a, b, c, d = order
    return {0: [], 1: [(a, b), (a, c), (a, d)], 2: [(a, c), (a, d), (b, d), (b, c)],
            3: [(a, d), (b, d), (c, d)], 4: []}[len(inner)]


def marching_tetrahedra(values, origin, cell):
    """Vertices on the grid edges that the surface crosses, and outward triangles and quads."""
    cuts = {signs: cut(signs) for signs in itertools.product((False, True), repeat=4)}
    tetrahedra = cell_tetrahedra()
    index, vertices, polygons = {}, [], []

    def crossing(p, q):
        if (p, q) not in index:
            index[p, q] = len(vertices)
            t = values[p] / (values[p] - values[q])
            vertices.append([o + (s + t * (e - s)) * cell for o, s, e in zip(origin, p, q)])
        return index[p, q]

    for i, j, k in sorted(values):
        for tetrahedron in tetrahedra:
            corners = [(i + di, j + dj, k + dk) for di, dj, dk in tetrahedron]
            if not all(c in values for c in corners):
                continue
            edges = cuts[tuple(values[c] < 0.0 for c in corners)]
            if edges:
                polygons.append([crossing(corners[p], corners[q]) for p, q in edges])
    return vertices, polygons


def project(field, vertices, step):
    """Moves vertices onto the surface along the gradient."""
    for _ in range(2):
        for p in vertices:
            value = field(*p)
            gradient = []
            for axis in range(3):
                q = list(p)
                q[axis] += step
                gradient.append((field(*q) - value) / step)
            norm2 = max(0.25, sum(g * g for g in gradient))
            for axis in range(3):
                p[axis] -= value * gradient[axis] / norm2


def relax(vertices, polygons):
    """Moves every vertex half-way to the mean of its neighbours: evens the triangles out."""
    total = [[0.0, 0.0, 0.0, 0] for _ in vertices]
    for polygon in polygons:
        for a, b in zip(polygon, polygon[1:] + polygon[:1]):
            for s, t in ((a, b), (b, a)):
                for axis in range(3):
                    total[s][axis] += vertices[t][axis]
                total[s][3] += 1
    for p, t in zip(vertices, total):
        for axis in range(3):
            p[axis] += 0.5 * (t[axis] / t[3] - p[axis])


def split(vertices, polygons):
    """Triangles: quads are cut along their shorter diagonal."""
    def distance2(a, b):
        return sum((p - q) ** 2 for p, q in zip(vertices[a], vertices[b]))

    triangles = []
    for polygon in polygons:
        if len(polygon) == 3:
            triangles.append(tuple(polygon))
            continue
        a, b, c, d = polygon
        triangles += ([(a, b, c), (a, c, d)] if distance2(a, c) <= distance2(b, d)
                      else [(a, b, d), (b, c, d)])
    return triangles


def make_toy(name):
    """Vertices in whole micrometres about the bounding box's centre, and outward triangles."""
    scale, cell, melt, limbs = TOYS[name]
    field = make_field(limbs, melt)
    cell /= scale
    vertices, polygons = marching_tetrahedra(*sample_grid(field, limbs, cell), cell)
    for _ in range(RELAXATIONS):
        relax(vertices, polygons)
    project(field, vertices, 0.01)
    whole = [[round(scale * MICROMETRES_PER_MILLIMETRE * c) for c in p] for p in vertices]
    centre = [(min(p[axis] for p in whole) + max(p[axis] for p in whole)) // 2 for axis in range(3)]
    return [tuple(c - o for c, o in zip(p, centre)) for p in whole], split(vertices, polygons)


def write_ply(path, vertices, triangles, comment):
    """Binary little-endian PLY in metres; single floats resolve a hundredth of a micrometre."""
    header = ["ply", "format binary_little_endian 1.0", "comment " + comment,
              "comment Written by scripts/make_models.py; metres.",
              f"element vertex {len(vertices)}", "property float x", "property float y",
              "property float z", f"element face {len(triangles)}",
              "property list uchar int vertex_indices", "end_header"]
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\n").encode("ascii"))
        for p in vertices:
            file.write(struct.pack("<3f", *(c / 1e6 for c in p)))
        for t in triangles:
            file.write(struct.pack("<B3i", 3, *t))


def make_toys(folder):
    for name in TOYS:
        vertices, triangles = make_toy(name)
        write_ply(folder / f"{name}.ply", vertices, triangles, f"A free-form toy: {name}")
