"""The sketch of a mesh with its parts (`hvi-run mesh SCRIPT`), read back from its SVG: what is drawn is the mesh.

Of every geometry in the plane: triangles are cells, each once; lines of a part are facets of the boundary, as long as the part is; the arrow of a part
begins on the part and leaves the body along its normal, known in closed form; no name covers another mark. In space: in the middle of each facet
that nothing stands before is the colour of its part. Names of pieces of the body lie on them, or a line leads to them.
usage: sketch.py HVI_RUN SOURCE_FOLDER"""
import base64
import collections
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree
import zlib

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


def pixels(png):
    """Of a PNG of our own: 8 bits, four channels, each row the difference to the one above."""
    data, at, size = b"", 8, None
    while at < len(png):
        n, kind = int.from_bytes(png[at:at + 4], "big"), png[at + 4:at + 8]
        if kind == b"IHDR":
            size = int.from_bytes(png[at + 8:at + 12], "big"), int.from_bytes(png[at + 12:at + 16], "big")
        data += png[at + 8:at + 8 + n] if kind == b"IDAT" else b""
        at += 12 + n
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(size[1], 1 + 4 * size[0])
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(size[1], size[0], 4)


class Sketch:
    """Marks of the file, and the map from the plane of the picture to its pixels."""

    def __init__(self, path):
        self.fills, self.lines, self.words, self.image = [], [], [], None
        for mark in xml.etree.ElementTree.parse(path).getroot():
            if mark.tag == SVG + "text":
                self.words.append((mark.text, float(mark.get("x")), float(mark.get("y")), float(mark.get("font-size")), mark.get("text-anchor")))
            elif mark.tag == SVG + "image":
                self.corner = np.array([float(mark.get("x")), float(mark.get("y"))])
                self.image = pixels(base64.b64decode(mark.get("href").split(",")[1]))
                self.fine = self.image.shape[1] / float(mark.get("width"))
            elif mark.get("points"):
                spots = np.array([tuple(map(float, pair.split(","))) for pair in mark.get("points").split()])
                if mark.tag == SVG + "polygon":
                    self.fills.append((spots, mark.get("fill")))
                else:
                    self.lines.append((spots, mark.get("stroke"), float(mark.get("stroke-width"))))
        self.triangles = [spots[:3] for spots, _ in self.fills if len(spots) == 4]
        self.dots = [spots.mean(axis=0) for spots, _ in self.fills if len(spots) > 10]

    def fit(self, points):
        """One scale for both axes, y upward: what makes the two boxes agree; an image fills the room that there is."""
        low, high = points.min(axis=0), points.max(axis=0)
        if self.image is None:
            drawn = np.concatenate(self.triangles)
            self.low = drawn.min(axis=0)
            scale = (drawn.max(axis=0) - self.low) / (high - low)
            assert abs(scale[0] / scale[1] - 1) < 1e-3, scale
            self.scale = scale[0]
        else:
            self.low, self.scale = self.corner, min(550 / (high[0] - low[0]), 420 / (high[1] - low[1]))
        self.to_plane = lambda spot: (low[0] + (spot[0] - self.low[0]) / self.scale, high[1] - (spot[1] - self.low[1]) / self.scale)
        self.to_pixel = lambda p: np.array([self.low[0] + (p[0] - low[0]) * self.scale, self.low[1] + (high[1] - p[1]) * self.scale])

    def pixel(self, spot):
        """What the image has at a spot of the picture."""
        x, y = ((np.asarray(spot) - self.corner) * self.fine).astype(int)
        return self.image[min(max(y, 0), self.image.shape[0] - 1), min(max(x, 0), self.image.shape[1] - 1)]

    def part_at(self, spot, colours):
        """The part whose colour is there, darker or lighter by the light; None: nothing is drawn; "?": colours that are mixed at an edge."""
        seen_colour = self.pixel(spot).astype(float)
        if seen_colour[3] < 255:
            return None
        off = {}
        for name, colour in colours.items():
            own = np.array([int(colour[k:k + 2], 16) for k in (1, 3, 5)], float)
            off[name] = min(np.abs(np.minimum(own * light, 255) - seen_colour[:3]).max() for light in np.linspace(0.66, 1.09, 87))
        name = min(off, key=off.get)
        return name if off[name] < 4 else "?"

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
        box = boxes["pole"]
        if dim == 2:
            drawn = np.concatenate([*sketch.triangles, *(s for s, _, w in sketch.lines if w == 3)])
            assert not any(box[0] < x < box[2] and box[1] < y < box[3] for x, y in drawn), (name, "the name of the point covers the body")
        assert len(sketch.dots) == 1
        place = np.zeros((1, 3))
        place[0, :dim] = POINTS[name]
        assert np.abs(sketch.dots[0] - sketch.to_pixel(seen(place, dim)[0][:2])).max() < 2 * PIXEL


TURN, TILT = 0.6, 0.45
VIEW = np.array([[math.cos(TURN), 0, -math.sin(TURN)],
                 [-math.sin(TILT) * math.sin(TURN), math.cos(TILT), -math.sin(TILT) * math.cos(TURN)],
                 [math.cos(TILT) * math.sin(TURN), math.sin(TILT), math.cos(TILT) * math.cos(TURN)]])


def seen(points, dim):
    """To the right, up (and towards the viewer): from the front, right and above as pictures are."""
    return points[:, :2] if dim == 2 else points @ VIEW.T


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


def skin_of(points, cells):
    """Faces of one cell only, each with its cell and its outward normal."""
    faces = collections.Counter(key(np.delete(c, i)) for c in cells for i in range(4))
    out = []
    for number, c in enumerate(cells):
        for i in range(4):
            face = np.delete(c, i)
            if faces[key(face)] == 1:
                a, b, d = points[face]
                normal = np.cross(b - a, d - a)
                out.append((face, number, normal * np.sign(normal @ (a - points[c[i]])) / np.linalg.norm(normal)))
    return out


def in_front(skin, points):
    """By facet: is its middle seen, or does another one stand before it?"""
    corners = seen(points, 3)[np.array([face for face, _, _ in skin])]
    middles = corners.mean(axis=1)
    a, b, d = corners[:, 0, :2], corners[:, 1, :2], corners[:, 2, :2]
    area = (b[:, 0] - a[:, 0]) * (d[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (d[:, 0] - a[:, 0])
    area = np.where(np.abs(area) > 1e-9 * np.abs(area).max(), area, np.inf)
    out = []
    for number, (x, y, depth) in enumerate(middles):
        u = ((b[:, 0] - x) * (d[:, 1] - y) - (b[:, 1] - y) * (d[:, 0] - x)) / area
        v = ((d[:, 0] - x) * (a[:, 1] - y) - (d[:, 1] - y) * (a[:, 0] - x)) / area
        w = 1 - u - v
        over = np.isfinite(area) & (u > 0) & (v > 0) & (w > 0)
        heights = u * corners[:, 0, 2] + v * corners[:, 1, 2] + w * corners[:, 2, 2]
        over[number] = False
        out.append(not (heights[over] > depth + 1e-9).any())
    return out


PLAIN = "#e4e4e4"


def facets_have_colours(sketch, points, cells, colours, part_of):
    """In the middle of every facet that is seen and large enough: the colour of its part, or of any where part_of does not know. Those parts."""
    flat, skin, out = seen(points, 3)[:, :2], skin_of(points, cells), []
    for (face, cell, normal), shown in zip(skin, in_front(skin, points)):
        a, b, d = flat[face] * sketch.scale
        longest = max(math.dist(a, b), math.dist(b, d), math.dist(d, a))
        large = abs((b - a)[0] * (d - a)[1] - (b - a)[1] * (d - a)[0]) > 6 * longest  # pixels: no line of an edge goes through the middle
        if normal @ VIEW[2] < 0.1 or not shown or not large:
            continue
        part = sketch.part_at(sketch.to_pixel(flat[face].mean(axis=0)), colours)
        assert part == "?" or part is not None and part_of(cell, normal) in (None, part), (face, part, part_of(cell, normal))
        out.append(part)
    assert out.count("?") <= 0.03 * len(out), (out.count("?"), len(out))
    return out


BODIES = """mesh lower = box(4, {low}, 3, cells = [8, 2, 6])
mesh upper = box(2, {high}, 2, cells = [5, 2, 5], at = [1, {low}, 0.5])
mesh both = {pieces}
part foundation = both where y < {low}
part block = both where y > {low}
part seam = pair(lower.top, upper.bottom)
space V = scalar P1 on both, zero on base
part base = lower.bottom
superpotential film(s) = s^2
find u in V such that for all v in V
  integral(both, dot(grad(u), grad(v))) + integral(seam, film^0(jump(u); jump(v))) >= integral(both, v)
report fields u
"""


def check_bodies(folder):
    """Two bodies on each other: what the upper one covers is not seen, and each name is where its body is."""
    for low, high, pieces in ((1.0, 1.0, "lower + upper"), (0.2, 1.5, "upper + lower"), (1.5, 0.2, "upper + lower")):
        script = folder / "bodies.hvi"
        script.write_text(BODIES.format(low=low, high=high, pieces=pieces))
        for command in ("mesh", "run"):
            done = subprocess.run([PROGRAM, command, script, "-o", folder / "bodies", "--quiet"], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
        sketch, grid = Sketch(folder / "bodies/bodies_mesh.svg"), meshio.read(next((folder / "bodies").glob("*.vtu")))
        cells = np.concatenate([c.data for c in grid.cells])
        colours = {text.removesuffix(" (behind)"): colour for text, colour in sketch.colours().items()}
        sketch.fit(seen(grid.points, 3)[:, :2])
        piece = lambda cell, normal: "block" if grid.points[cells[cell]].mean(axis=0)[1] > low else "seam" if normal[1] > 0.5 else "foundation"
        assert len(facets_have_colours(sketch, grid.points, cells, colours, piece)) > 60
        for name in ("foundation", "block"):
            left, top, right, bottom = box_of_words(sketch.name(name))
            under = {sketch.part_at((x, y), colours) if inside_image(sketch, (x, y)) else None for x in np.linspace(left, right, 5) for y in (top, bottom)}
            leads = [sketch.part_at(s[0], colours) for s, colour, _ in sketch.lines if len(s) == 2 and colour == "#737373" and near(s[1], (left, top, right, bottom))]
            on_it = under - {"?"} in ([{name}, {name, "seam"}, {"seam"}] if name == "foundation" else [{name}])
            assert on_it or leads and leads[0] in (name, "seam") and under - {"?"} == {None}, (name, low, under, leads)
        assert "base (behind)" in sketch.colours()


def inside_image(sketch, spot):
    high, wide = sketch.image.shape[:2]
    x, y = (np.asarray(spot) - sketch.corner) * sketch.fine
    return 0 <= x < wide and 0 <= y < high


def near(spot, box, reach=14):
    return box[0] - reach < spot[0] < box[2] + reach and box[1] - reach < spot[1] < box[3] + reach


def check_line(folder):
    """An interval: its cells between ticks, its ends with their normals."""
    script = folder / "bar.hvi"
    script.write_text("mesh bar = interval(3, cells = 6, at = 1)\npart left = bar.left\npart right = bar.right\npart thick = bar where x < 2\n"
                      "space V = scalar P1 on bar, zero on left\nfind u in V such that for all v in V integral(bar, grad(u).x*grad(v).x) = integral(bar, v)\n")
    done = subprocess.run([PROGRAM, "mesh", script, "-o", folder / "bar"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    sketch = Sketch(folder / "bar/bar_mesh.svg")
    colours = sketch.colours()
    ticks = sorted(s[0][0] for s, _, width in sketch.lines if width == 0.8)
    assert len(ticks) == 7 and np.allclose(np.diff(ticks), (ticks[-1] - ticks[0]) / 6, atol=2 * PIXEL)
    thick = [s for s, colour, width in sketch.lines if width == 6 and colour == colours["thick"]]
    assert len(thick) == 2 and abs(max(s[:, 0].max() for s in thick) - ticks[2]) < 2 * PIXEL
    for part, place, way in (("left", ticks[0], -1), ("right", ticks[-1], 1)):
        (begin, tip, _), = [a for a in sketch.arrows() if a[2] == colours[part]]
        assert abs(begin[0] - place) < 2 * PIXEL and abs(tip[0] - begin[0] - way * ARROW) < 2 * PIXEL and abs(tip[1] - begin[1]) < PIXEL
    assert len(sketch.dots) == 2


def check_space(folder, name, groups):
    sketch, points, cells, _ = sketch_of(folder, name, groups)
    flat = seen(points, 3)[:, :2]
    sketch.fit(flat)
    colours = {text.removesuffix(" (behind)"): colour for text, colour in sketch.colours().items()}
    n = len(facets_have_colours(sketch, points, cells, {**colours, "": PLAIN}, lambda cell, normal: None))
    assert n > 20, (name, n)
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
    check_bodies(pathlib.Path(temporary))
    check_line(pathlib.Path(temporary))
print(f"the sketches of {len(geometries)} geometries are their meshes")
