#!/usr/bin/env python3
"""Writes small valid files of every kind that the fuzzers begin with, and their dictionaries:

    make_seeds.py CORPUS_FOLDER REPOSITORY
"""
import pathlib
import struct
import sys

POINTS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.5), (0.0, 1.0, 0.25), (1.0, 1.0, -1.0)]
NORMAL = (0.0, 0.0, 1.0)

DICTIONARIES = {
    "ply": ["ply\n", "format ascii 1.0\n", "format binary_little_endian 1.0\n",
            "format binary_big_endian 1.0\n", "element vertex ", "element face ", "property ",
            "property list uchar int vertex_indices\n", "property float x\n", "double", "short",
            "uint", "nx", "ny", "nz", "comment", "end_header\n", "2147483647", "nan"],
    "pcd": ["VERSION .7\n", "FIELDS x y z", "SIZE 4 4 4", "TYPE F F F", "COUNT 1 1 1", "WIDTH ",
            "HEIGHT ", "VIEWPOINT 0 0 0 1 0 0 0\n", "POINTS ", "DATA ascii\n", "DATA binary\n",
            "DATA binary_compressed\n", " normal_x normal_y normal_z", " rgb", "1048576",
            "2147483647", "nan"],
    "vtk": ["# vtk DataFile Version 3.0\n", "ASCII\n", "BINARY\n", "DATASET POLYDATA\n",
            "POINTS 4 float\n", "POLYGONS ", "TRIANGLE_STRIPS ", "VERTICES ", "OFFSETS ",
            "CONNECTIVITY ", "vtktypeint64", "POINT_DATA ", "CELL_DATA ", "NORMALS n ", "SCALARS s ",
            "LOOKUP_TABLE ", "VECTORS v ", "TENSORS t ", "TEXTURE_COORDINATES t ",
            "COLOR_SCALARS c ", "FIELD f ", "METADATA\n", "double\n", "unsigned_char\n",
            "2147483647"],
    "xml_outline": ["<robot name=\"a\">", "</robot>", "<link name=\"", "<joint ", "<!--", "-->",
                    "<?xml", "?>", "<![CDATA[", "]]>", "<!DOCTYPE", "/>", "&amp;"],
    "scene": ["extends: ", "table:", "containers:", "camera:", "objects:", "pile:", "standing:",
              "&a", "*a", "<<:", "!!str", "---\n", "[", "]", "{", "}", "- ", ": ", ".nan", "1e999"],
    "lzf": ["\xe0\xff\x00", "\x20\x00", "\x1f"],
}


def flat(rows, order):
    return b"".join(struct.pack(order + "3f", *row) for row in rows)


def lzf(plain):
    """Plain runs only, and one copy behind them that repeats their last bytes."""
    runs = b"".join(bytes([len(plain[i:i + 32]) - 1]) + plain[i:i + 32]
                    for i in range(0, len(plain), 32))
    return runs + bytes([(7 << 5) | 0, 3, 11]), plain + (plain[-12:] * 2)[:12]


def ply_seeds():
    head = "ply\nformat {} 1.0\ncomment seed\nelement vertex 4\n"
    xyz = "property float x\nproperty float y\nproperty float z\n"
    normals = "property float nx\nproperty float ny\nproperty float nz\n"
    faces = "element face 2\nproperty list uchar int vertex_indices\n"
    text = "".join("%g %g %g\n" % p for p in POINTS)
    yield (head.format("ascii") + xyz + "end_header\n" + text).encode()
    yield (head.format("ascii") + xyz + faces + "end_header\n" + text + "3 0 1 2\n4 0 1 3 2\n").encode()
    for name, order in (("binary_little_endian", "<"), ("binary_big_endian", ">")):
        rows = b"".join(struct.pack(order + "6f", *p, *NORMAL) for p in POINTS)
        indices = struct.pack(order + "B3iB4i", 3, 0, 1, 2, 4, 0, 1, 3, 2)
        yield (head.format(name) + xyz + normals + "end_header\n").encode() + rows
        yield (head.format(name) + xyz + faces + "end_header\n").encode() + flat(POINTS, order) + indices
        tagged = "property double x\nproperty short y\nproperty list uchar int t\nproperty float z\n"
        body = b"".join(struct.pack(order + "dhBif", p[0], int(p[1]), 1, 7, p[2]) for p in POINTS)
        yield (head.format(name) + tagged + "end_header\n").encode() + body


def pcd_seeds():
    head = ("# .PCD v0.7\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\nWIDTH {}\nHEIGHT {}\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA {}\n")
    xyz = ("x y z", "4 4 4", "F F F", "1 1 1")
    text = "".join("%g %g %g\n" % p for p in POINTS)
    yield (head.format(*xyz, 4, 1, 4, "ascii") + text).encode()
    yield (head.format(*xyz, 2, 2, 4, "ascii") + "nan nan nan\n" + text[6:]).encode()
    yield head.format(*xyz, 4, 1, 4, "binary").encode() + flat(POINTS, "<")
    padded = ("x y z _ rgb", "4 4 4 1 4", "F F F U U", "1 1 1 4 1")
    body = b"".join(struct.pack("<3f4sI", *p, b"pads", 7) for p in POINTS)
    yield head.format(*padded, 2, 2, 4, "binary").encode() + body
    columns = b"".join(struct.pack("<4f", *(p[k] for p in POINTS)) for k in range(3))
    for packed, plain, count in ((*lzf(columns), 5), ):
        size = struct.pack("<II", len(packed), len(plain))
        yield head.format(*xyz, count, 1, count, "binary_compressed").encode() + size + packed


def vtk_seeds():
    head = "# vtk DataFile Version {}\ntitle\n{}\nDATASET POLYDATA\n"
    text = "".join("%g %g %g\n" % p for p in POINTS)
    yield (head.format("3.0", "ASCII") + "POINTS 4 float\n" + text + "POLYGONS 1 5\n4 0 1 3 2\n"
           "TRIANGLE_STRIPS 1 5\n4 0 1 2 3\nPOINT_DATA 4\nNORMALS n float\n" + "0 0 1\n" * 4 +
           "SCALARS s float 1\nLOOKUP_TABLE default\n1 2 3 4\n").encode()
    yield (head.format("5.1", "ASCII") + "POINTS 4 double\n" + text + "METADATA\nINFORMATION 0\n\n"
           "POLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\nCONNECTIVITY vtktypeint64\n0 1 2 1 3 2\n"
           "CELL_DATA 2\nFIELD f 1\na 1 2 int\n7 8\n").encode()
    yield ((head.format("3.0", "BINARY") + "POINTS 4 float\n").encode() + flat(POINTS, ">") +
           b"\nPOLYGONS 1 4\n" + struct.pack(">4i", 3, 0, 1, 2) + b"\nPOINT_DATA 4\nNORMALS n float\n" +
           flat([NORMAL] * 4, ">") + b"\nCOLOR_SCALARS c 3\n" + bytes(12) + b"\n")
    yield ((head.format("5.1", "BINARY") + "POINTS 4 float\n").encode() + flat(POINTS, ">") +
           b"\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n" + struct.pack(">2q", 0, 3) +
           b"\nCONNECTIVITY vtktypeint64\n" + struct.pack(">3q", 0, 1, 2) + b"\n")


def lzf_seeds():
    for plain in (b"a", b"abcabcabc" * 5, bytes(100)):
        packed, whole = lzf(plain.ljust(12, b"."))
        yield struct.pack("<H", len(whole)) + packed


def xml_outline_seeds():
    yield (b"<?xml version=\"1.0\"?>\n<!-- an arm -->\n<robot name=\"r\">\n  <link name=\"arm\"/>\n"
           b"  <joint name='j' type=\"fixed\"><parent link=\"a\"/><child link=\"arm\"/></joint>\n"
           b"  <text><![CDATA[a < b]]></text>\n</robot>\n")


def main():
    corpus, repository = map(pathlib.Path, sys.argv[1:])
    seeds = {"ply": ply_seeds(), "pcd": pcd_seeds(), "vtk": vtk_seeds(), "lzf": lzf_seeds(),
             "xml_outline": xml_outline_seeds(),
             "scene": (f.read_bytes() for f in sorted((repository / "scenes").glob("*.yaml")))}
    for name, files in seeds.items():
        folder = corpus / name
        folder.mkdir(parents=True, exist_ok=True)
        for i, content in enumerate(files):
            (folder / f"seed-{i}").write_bytes(content)
        words = "".join('"%s"\n' % "".join(c if c.isascii() and c.isalnum() or c in " .:_"
                                           else "\\x%02x" % ord(c) for c in word)
                        for word in DICTIONARIES[name])
        (corpus / f"{name}.dict").write_text(words)


if __name__ == "__main__":
    main()
