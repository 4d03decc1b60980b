"""The sketch of a mesh with its parts (`hvi-run mesh SCRIPT`), read back from its SVG: what is drawn is the mesh.

Of every geometry: triangles are cells (in space the facets that face us), each once; lines of a part are facets of the boundary, as long as the part
is; the arrow of a part begins on the part and leaves the body along its normal, known in closed form; no name covers another mark.
usage: sketch.py HVI_RUN SOURCE_FOLDER"""
import collections
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import meshio
import numpy as np

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
SVG = "{http://www.w3.org/2000/svg}"
PIXEL = 0.011  # numbers of the file have two decimals
ARROW = 26.0
LEFT, RIGHT, UP, DOWN = (-1, 0), (1, 0), (0, 1), (0, -1)


# By geometry and part: how far a point is from it, and its outward normal there.
PLANE = {
    "disk": {"rim": (lambda x, y: math.hypot(x, y) - 1, lambda x, y: (x, y))},
    "annulus": {"inner": (lambda x, y: math.hypot(x, y) - 0.5, lambda x, y: (-2 * x, -2 * y)),
                "outer": (lambda x, y: math.hypot(x, y) - 1, lambda x, y: (x, y))},
    "plate_with_hole": {"left": (lambda x, y: x, lambda x, y: LEFT), "right": (lambda x, y: x - 2, lambda x, y: RIGHT),
                        "bottom": (lambda x, y: y, lambda x, y: DOWN), "top": (lambda x, y: y - 1, lambda x, y: UP),
                        "hole": (lambda x, y: math.hypot(x - 1, y - 0.5) - 0.2, lambda x, y: (5 * (1 - x), 5 * (0.5 - y)))},
    "half_disk": {"top": (lambda x, y: y - 1, lambda x, y: UP), "bottom": (lambda x, y: math.hypot(x, y - 1) - 1, lambda x, y: (x, y - 1))},
    "quarter_disk": {"top": (lambda x, y: y - 1, lambda x, y: UP), "left": (lambda x, y: x, lambda x, y: LEFT),
                     "bottom": (lambda x, y: math.hypot(x, y - 1) - 1, lambda x, y: (x, y - 1))},
    "graded_rectangle": {"left": (lambda x, y: x, lambda x, y: LEFT), "right": (lambda x, y: x - 2, lambda x, y: RIGHT),
                         "bottom": (lambda x, y: y, lambda x, y: DOWN), "top": (lambda x, y: y - 1, lambda x, y: UP)},
    "l_shape": {"left": (lambda x, y: x, lambda x, y: LEFT), "right": (lambda x, y: x - 1, lambda x, y: RIGHT),
                "bottom": (lambda x, y: y, lambda x, y: DOWN), "top": (lambda x, y: y - 1, lambda x, y: UP),
                "notch": (lambda x, y: min(abs(x - 0.5), abs(y - 0.5)), lambda x, y: RIGHT if abs(x - 0.5) < abs(y - 0.5) else UP)},
    "dogbone": {"left": (lambda x, y: x, lambda x, y: LEFT), "right": (lambda x, y: x - 4, lambda x, y: RIGHT),
                "bottom": (lambda x, y: y, lambda x, y: DOWN), "top": (lambda x, y: y - 1, lambda x, y: UP)},
}
POINTS = {"half_disk": (0, 0), "quarter_disk": (0, 0), "half_ball": (0, 0, 0)}


def table_of_geometries():
    text = (SOURCE / "solver/mesh/geometries.cpp").read_text()
    entry = re.compile(r'\{"(\w+)",\s*([23]),\s*\{([^}]*)\},\s*\{([^}]*)\},\s*\{([^}]*)\}')
    out = {m[1]: (int(m[2]), re.findall(r"\w+", m[5])) for m in entry.finditer(text[text.index("geometries() {"):])}
    assert len(out) >= 12, out
    return out


class Sketch:
    """Marks of the file, and the map from the plane of the picture to its pixels."""

    def __init__(self, path):
        self.fills, self.lines, self.words = [], [], []
        for mark in xml.etree.ElementTree.parse(path).getroot():
            if mark.tag == SVG + "text":
                self.words.append((mark.text, float(mark.get("x")), float(mark.get("y")), float(mark.get("font-size")), mark.get("text-anchor")))
            elif mark.get("points"):
                spots = np.array([tuple(map(float, pair.split(","))) for pair in mark.get("points").split()])
                if mark.tag == SVG + "polygon":
                    self.fills.append((spots, mark.get("fill")))
                else:
                    self.lines.append((spots, mark.get("stroke"), float(mark.get("stroke-width"))))
        self.triangles = [spots[:3] for spots, _ in self.fills if len(spots) == 4]
        self.dots = [spots.mean(axis=0) for spots, _ in self.fills if len(spots) > 10]

    def fit(self, points):
        """One scale for both axes, y upward: what makes the two boxes agree."""
        low, high = points.min(axis=0), points.max(axis=0)
        drawn = np.concatenate(self.triangles)
        self.low, self.high = drawn.min(axis=0), drawn.max(axis=0)
        scale = (self.high - self.low) / (high - low)
        assert abs(scale[0] / scale[1] - 1) < 1e-3, scale
        self.scale = scale[0]
        self.to_plane = lambda spot: (low[0] + (spot[0] - self.low[0]) / self.scale, high[1] - (spot[1] - self.low[1]) / self.scale)
        self.to_pixel = lambda p: np.array([self.low[0] + (p[0] - low[0]) * self.scale, self.low[1] + (high[1] - p[1]) * self.scale])

    def colours(self):
        """Of parts, from the key: a short thick line with the name behind it."""
        out = {}
        for name, x, y, size, _ in self.words:
            for spots, colour, width in self.lines:
                if size == 12 and width == 4 and abs(spots[1][0] + 8 - x) < PIXEL and abs(spots[1][1] + 4 - y) < PIXEL:
                    out[name] = colour
        return out

    def arrows(self):
        """(begin, tip, colour) of the lines that barbs follow, but not those of the axes, which are grey."""
        return [(a[0][0], a[0][1], a[1]) for a, b in zip(self.lines, self.lines[1:])
                if a[2] == b[2] == 1.6 and len(a[0]) == 2 and len(b[0]) == 3 and np.allclose(a[0][1], b[0][1], atol=PIXEL) and a[1] != "#737373"]

    def name(self, text):
        return next(w for w in self.words if w[0] == text and w[3] == 13)


def box_of_words(words):
    text, x, y, size, anchor = words
    width = 0.6 * size * len(text)
    left = x - {"start": 0, "middle": 0.5, "end": 1}[anchor] * width
    return left, y - 0.75 * size, left + width, y


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def sketch_of(folder, name, groups):
    parts = "".join(f'part {g} = m.group("{g}")\n' for g in groups if g != "body")
    script = folder / f"{name}.hvi"
    script.write_text(f"mesh m = {name}()\n{parts}space V = scalar P1 on m, zero on {groups[0]}\nfind u in V such that for all v in V\n"
                      "  integral(m, dot(grad(u), grad(v))) = integral(m, v)\nreport fields u\n")
    said = {}
    for command in ("mesh", "run"):
        done = subprocess.run([PROGRAM, command, script, "-o", folder / name, "--quiet"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        said[command] = done.stdout
    lengths = {m[1]: float(m[2]) for m in re.finditer(r"^  (\w+) +\d+ facets  length (\S+)", said["mesh"], re.M)}
    grid = meshio.read(next((folder / name).glob("*.vtu")))
    return Sketch(folder / name / f"{name}_mesh.svg"), grid.points, np.concatenate([c.data for c in grid.cells]), lengths


def key(corners):
    return tuple(sorted(corners))


def nodes_at(sketch, points, spots):
    """The numbers of the nodes that spots of the picture are; each is one."""
    places = np.array([sketch.to_pixel(p) for p in points])
    found = np.argmin(np.hypot(*(places[None, :, :] - np.asarray(spots)[:, None, :]).transpose(2, 0, 1)), axis=1)
    off = np.abs(places[found] - spots).max()
    assert off < 2 * PIXEL, off
    return found


def names_are_free(sketch, name, groups, dim):
    boxes = {g: box_of_words(sketch.name(g)) for g in groups if any(w[0] == g and w[3] == 13 for w in sketch.words)}
    for g, box in boxes.items():
        for h, other in boxes.items():
            assert g == h or not overlap(box, other), (name, g, h)
        for dot in sketch.dots:
            assert not overlap(box, (*(dot - 4.5), *(dot + 4.5))), (name, g, "a dot")
    if name in POINTS:
        drawn = np.concatenate([*sketch.triangles, *([s for s, _, w in sketch.lines if w == 3] if dim == 2 else [])])
        box = boxes["pole"]
        assert not any(box[0] < x < box[2] and box[1] < y < box[3] for x, y in drawn), (name, "the name of the point covers the body")
        assert len(sketch.dots) == 1
        place = np.zeros((1, 3))
        place[0, :dim] = POINTS[name]
        assert np.abs(sketch.dots[0] - sketch.to_pixel(seen(place, dim)[0])).max() < 2 * PIXEL


def seen(points, dim):
    """From the front, right and above: turned by 0.6 about the vertical, tilted by 0.45."""
    if dim == 2:
        return points[:, :2]
    x, y, z = points.T
    across, away = math.cos(0.6) * x + math.sin(0.6) * z, math.cos(0.6) * z - math.sin(0.6) * x
    return np.column_stack([across, math.cos(0.45) * y - math.sin(0.45) * away])


def check_plane(folder, name, groups):
    sketch, points, cells, lengths = sketch_of(folder, name, groups)
    flat = points[:, :2]
    sketch.fit(flat)
    drawn = collections.Counter(key(nodes_at(sketch, flat, t)) for t in sketch.triangles)
    assert drawn == collections.Counter(key(c) for c in cells), name
    edges = collections.Counter(key((c[i], c[(i + 1) % 3])) for c in cells for i in range(3))
    colours = sketch.colours()
    sides = [g for g in groups if g not in ("body", "pole")]
    for part in sides:
        of_part = [s for s, colour, width in sketch.lines if width == 3 and colour == colours[part]]
        assert all(edges[key(nodes_at(sketch, flat, s))] == 1 for s in of_part), (name, part, "a line that is no facet of the boundary")
        length = sum(math.dist(*s) for s in of_part) / sketch.scale
        assert abs(length - lengths[part]) < 1e-3 * lengths[part], (name, part, length, lengths[part])
        (begin, tip, _), = [a for a in sketch.arrows() if a[2] == colours[part]]
        along = np.array([tip[0] - begin[0], begin[1] - tip[1]])
        assert abs(math.hypot(*along) - ARROW) < 2 * PIXEL, (name, part, along)
        if part in PLANE[name]:
            distance, normal = PLANE[name][part]
            place = sketch.to_plane(begin)
            assert abs(distance(*place)) < 0.02, (name, part, place)  # sagitta of a facet
            assert np.abs(along / ARROW - normal(*place)).max() < 0.05, (name, part, along, normal(*place))
        text, x, y, _, _ = sketch.name(part)
        assert math.dist((x, y), tip) < 20, (name, part, "its name is far from its arrow")
    names_are_free(sketch, name, groups, 2)


def check_space(folder, name, groups):
    sketch, points, cells, _ = sketch_of(folder, name, groups)
    flat = seen(points, 3)
    faces = collections.Counter(key(np.delete(c, i)) for c in cells for i in range(4))
    expected = []
    view = np.cross([math.cos(0.6), 0, math.sin(0.6)], [math.sin(0.45) * math.sin(0.6), math.cos(0.45), -math.sin(0.45) * math.cos(0.6)])
    for c in cells:
        for i in range(4):
            face = np.delete(c, i)
            if faces[key(face)] > 1:
                continue
            a, b, d = points[face]
            normal = np.cross(b - a, d - a)
            normal *= np.sign(normal @ (a - points[c[i]])) / np.linalg.norm(normal)
            if normal @ view > 1e-9:
                expected.append(face)
    sketch.fit(flat)
    at = np.array([sketch.to_pixel(p) for p in flat])
    assert len(sketch.triangles) == len(expected), (name, len(sketch.triangles), len(expected))
    middles = np.array([t.mean(axis=0) for t in sketch.triangles])
    for face in expected:
        assert np.abs(middles - at[face].mean(axis=0)).max(axis=1).min() < 2 * PIXEL, (name, face)
    arrows = sketch.arrows()
    sides = [g for g in groups if g not in ("body", "pole") and f"{g} (behind)" not in sketch.colours()]
    assert len(arrows) == len(sides) > 0, (name, len(arrows), sides)
    for begin, tip, _ in arrows:
        assert math.dist(begin, tip) > 0.5 * ARROW - PIXEL, (name, "an arrow that is not seen")
    if name == "ball":  # the foot of the arrow is a point of the sphere: its normal is the place itself
        (begin, tip, _), = arrows
        place, along = np.array(sketch.to_plane(begin)), np.array([tip[0] - begin[0], begin[1] - tip[1]])
        assert np.abs(along / ARROW - place).max() < 0.1, (along / ARROW, place)
    names_are_free(sketch, name, groups, 3)


with tempfile.TemporaryDirectory() as temporary:
    geometries = table_of_geometries()
    for name, (dim, groups) in geometries.items():
        (check_plane if dim == 2 else check_space)(pathlib.Path(temporary), name, groups)
print(f"the sketches of {len(geometries)} geometries are their meshes")
