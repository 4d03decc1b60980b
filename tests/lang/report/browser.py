"""A report in a browser: headless Chromium is led through it by the DevTools protocol, every control is used, what the body looks like
is compared (48 x 32 pixels, so that drivers may differ in detail) with tests/lang/report/looks.json.
usage: browser.py HVI_RUN [--new-looks] [--shots FOLDER].   Exit code 77: there is no Chromium."""
import base64
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from devtools import Browser, chromium

PROGRAM = sys.argv[1]
LOOKS = pathlib.Path(__file__).parent / "looks.json"
NEW = "--new-looks" in sys.argv
SHOTS = pathlib.Path(sys.argv[sys.argv.index("--shots") + 1]) if "--shots" in sys.argv else None
SCRIPT = """mesh block = box(2, 1, 1, cells = [12, 6, 6])
part top = block.top
part bottom = block.bottom
tensor A = isotropic(lambda = 20, mu = 40)
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) with slope | r < 0 -> 0 | r < 0.02 -> 100*r | otherwise -> max(2 - 40*(r - 0.02), 0.1)
superpotential slip(w) = 0.05 * norm(w)
space V = vector P1 on block, zero on top
find u in V for t in [0, 1] by 5 steps from u = 0
such that for all v in V
    integral(block, A : eps(u') : eps(v)) + integral(block, B : eps(u) : eps(v))
  + integral(bottom, layer^0(u.nu; v.nu) + slip^0(u.tau; v.tau)) >= integral(block, dot([3*t*x, -12*t*x, 0], v))
report
  table a = u.y at [2, 0, 0], f = integral(bottom, layer.xi)
  fields u
"""
MEASURED = """units mm, N, s
mesh plate = rectangle(20 [mm], 10 [mm], cells = [6, 3])
part left = plate.left
part ground = plate.bottom
tensor B = isotropic(young = 70 [GPa], poisson = 0.3)
superpotential layer(r) = 50 [MPa/mm]*r^2
space V = vector P1 on plate, zero on left
find u in V for t in [0, 10] [s] by 4 steps from u = 0
such that for all v in V
    integral(plate, B : eps(u) : eps(v)) + integral(plate, 1 [GPa*s]*(eps(u') : eps(v))) + integral(ground, layer^0(u.nu; v.nu)) >= integral(plate, dot([0, -1 [N/mm^3]*t/(1 [s])], v))
report
  table tip = u.y at [20, 10] [mm], pressed = layer.xi at [20, 0] [mm]
"""
BAR = """mesh bar = interval(1, cells = 8)
part left = bar.left
part right = bar.right
space V = scalar P1 on bar, zero on left
superpotential spring(r) = 0.5*r^2
find u in V for t in [0, 2] by 4 steps from u = 0 such that for all v in V
  integral(bar, grad(u).x*grad(v).x) + integral(bar, 0.1*grad(u').x*grad(v).x) + integral(right, spring^0(u; v)) >= integral(bar, t*v)
report
  table a = u at [1]
"""
WORN = """mesh body = box(2, 1, 1, cells = [6, 3, 3])
part wall = body.left
part soft = body where x < 1
part hard = body where x > 1
tensor B = isotropic(lambda = 40, mu = 30)
state d on soft with rate 5*norm(eps(u)) from d = 0.1*y in [0, 0.95]
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] by 3 steps from u = 0
such that for all v in V
    integral(soft, (1 - d)*B : eps(u) : eps(v)) + integral(hard, B : eps(u) : eps(v)) = integral(body, dot([0.8*t, 0.4*t, 0], v))
report
  fields d
"""
failures = 0


def check(what, good, more=""):
    global failures
    if not good:
        failures += 1
        print("FAIL", what, more)
    return good


def compare(browser, name, looks):
    seen = browser.look()
    if NEW:
        looks[name] = seen
        return
    known = looks.get(name, [0] * len(seen))
    off = sum(abs(a - b) for a, b in zip(seen, known)) / len(seen)
    check(f"looks like {name}", off < 4.0, f"pixels are off by {off:.1f} of 255 in the mean")


def viewer(browser, looks):
    seen = lambda: browser.run("document.body.viewer.canvas.toDataURL()")
    label = lambda: browser.run("document.body.viewer.canvas.getAttribute('aria-label')")
    browser.run("document.getElementById('fields').scrollIntoView()")
    compare(browser, "stress", looks)
    of_stress = lambda numbers, which: browser.run(f"quantitiesOf({{ name: 's', components: 9 }}, {{ dim: 3 }})[{which}][1](Float64Array.of({numbers}), 0)")
    for numbers, mises, mean in (("7, 0, 0, 0, 0, 0, 0, 0, 0", 7, 7 / 3), ("0, 2, 0, 2, 0, 0, 0, 0, 0", 2 * 3 ** 0.5, 0), ("4, 0, 0, 0, 4, 0, 0, 0, 4", 0, 4)):
        check("invariants of stresses", abs(of_stress(numbers, 0) - mises) < 1e-12 and abs(of_stress(numbers, 1) - mean) < 1e-12, numbers)
    check("the picture is told to those who do not see it", "von Mises" in label() and "t = 1" in label(), label())
    check("the bar says that stresses are means", browser.run("document.body.viewer.meansNote.textContent") == "means at nodes")
    box = browser.run("(({ x, y, width, height }) => ({ x, y, width, height }))(document.body.viewer.canvas.getBoundingClientRect())")
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    browser.mouse("mouseReleased", x, y, button="left", clickCount=1)
    probed = "document.querySelector('#fields output.values').textContent"
    check("a click reads a value", browser.run(probed).startswith("at ("), browser.run(probed))
    before = seen()
    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    for k in range(1, 6):
        browser.mouse("mouseMoved", x + 20 * k, y + 6 * k, button="left", buttons=1)
    browser.mouse("mouseReleased", x + 100, y + 30, button="left", clickCount=1)
    check("dragging turns", seen() != before)
    compare(browser, "turned", looks)
    before = seen()
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-240)
    browser.wait(f"document.body.viewer.view.zoom > 1.1")
    check("the wheel zooms", seen() != before)

    browser.run("document.body.viewer.canvas.focus()")
    browser.key("0")
    compare(browser, "stress", looks)
    for key in ("ArrowLeft", "ArrowUp", "+", "-"):
        before = seen()
        browser.key(key)
        check(f"the key {key} does something", seen() != before)
    browser.key("0")
    browser.key(",")
    browser.wait("document.body.viewer.timeText.textContent === 't = 0.8'")
    browser.key(".")
    browser.wait("document.body.viewer.timeText.textContent === 't = 1'")
    browser.run("document.getElementById('play').click()")
    browser.wait("document.body.viewer.state.frame === 2")
    browser.run("document.getElementById('play').click()")
    browser.run("document.body.viewer.show(4)")

    browser.set("factor", 4)
    compare(browser, "deformed", looks)
    browser.set("contours", 16)
    compare(browser, "contours", looks)
    browser.set("cut", "x")
    browser.set("cut-at", 0.6)
    compare(browser, "cut", looks)
    browser.shot("report_cut")
    browser.set("cut", "none"), browser.set("contours", 0)
    browser.set("forces", True), browser.set("dots", True)
    legend = browser.run("document.body.viewer.legend.textContent")
    check("branches are named", all(word in legend for word in ("loaded", "softened", "slip")), legend)
    browser.key("ArrowDown"), browser.run("document.body.viewer.view.turn[1] = -0.35; document.body.viewer.draw()")
    compare(browser, "contact", looks)
    browser.shot("report_contact")
    browser.set("forces", False), browser.set("dots", False), browser.set("mesh", True)
    compare(browser, "mesh", looks)
    browser.set("fixed", True)
    check("colours of all times", browser.run("document.body.viewer.now.scale.low < document.body.viewer.now.scale.high"))
    for index in range(browser.run("document.body.viewer.quantities.length")):
        browser.set("quantity", index)
        check("every quantity has numbers", browser.run("Number.isFinite(document.body.viewer.now.scale.high)"), index)
    browser.run("document.getElementById('probe').click()")
    check("typed coordinates read a value", browser.run(probed).startswith("at ("))
    browser.run("document.getElementById('reset').click()")


def geometry(browser):
    """What viewer and pictures stand on: a cut of a linear field is that field, whatever cells it goes through, so its contours are straight; arrows."""
    off = browser.run("""(() => { const v = document.body.viewer, f = (p, i) => 2 * p[i] - 3 * p[i + 1] + 0.5 * p[i + 2] + 1, values = new Float32Array(v.points.length / 3);
        values.forEach((_, i) => { values[i] = f(v.points, 3 * i); });
        const worst = [];
        for (const [normal, at] of [[[1, 0, 0], 0.61], [[0, 1, 0], 0.37], [[0.6, 0, 0.8], 0.9]]) {
          const cut = cutThrough(v.cells, v.points, values, normal, at), p = cut.points;
          let area = 0, off = 0;
          for (let t = 0; t < p.length; t += 9) {
            const u = [0, 1, 2].map((k) => p[t + 3 + k] - p[t + k]), w = [0, 1, 2].map((k) => p[t + 6 + k] - p[t + k]);
            area += Math.hypot(u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]) / 2;
          }
          cut.values.forEach((value, i) => { off = Math.max(off, Math.abs(value - f(p, 3 * i)), Math.abs(p[3 * i] * normal[0] + p[3 * i + 1] * normal[1] + p[3 * i + 2] * normal[2] - at)); });
          worst.push([area, off]);
        }
        return worst; })()""")
    for (area, wrong), wanted in zip(off, (1, 2, 5 / 3)):  # of the block 2 x 1 x 1; the slanted cut goes from (1/6, 1) to (3/2, 0)
        check("cuts", wrong < 1e-5 and abs(area - wanted) < 1e-4, (area, wanted, wrong))
    for length, thick, head in ((1.0, 0.05, 0.2), (0.2, 0.2, 0.1)):  # four times as long as the shaft is thick, but at most half of the arrow
        along, wide = browser.run(f"""(() => {{ const points = [], normals = []; addArrow(points, normals, [1, 2, 3], [1, 2 + {length}, 3], {thick});
            const at = new Map(); for (let i = 0; i < points.length; i += 3) {{ const y = Math.round(1e6 * (points[i + 1] - 2)) / 1e6, r = Math.hypot(points[i] - 1, points[i + 2] - 3);
              at.set(y, Math.max(at.get(y) || 0, r)); }}
            return [[...at.keys()].sort((a, b) => a - b), [...at].sort((a, b) => a[0] - b[0]).map((e) => e[1])]; }})()""")
        check("arrows", all(abs(a - b) < 1e-5 for a, b in zip(along, (0, length - head, length))) and len(along) == 3, (along, head))
        check("arrows are wide at their heads", all(abs(a - b) < 1e-5 for a, b in zip(wide, (thick / 2, 1.4 * thick, 0))), wide)


def told(browser):
    """What is told of a body are its numbers: the bar, a click, a typed place, contours, points of laws, the cursor of a curve, times that are looked for."""
    browser.run("(async () => { const v = document.body.viewer; v.reset(); Object.assign(v.state, { factor: 3, forces: true, dots: true, fixed: false }); document.getElementById('fields').scrollIntoView(); await v.update(); })()")
    range_of, scale, numbers = browser.run("""(() => { const v = document.body.viewer, list = [...v.now.values];
        return [[Math.min(...list), Math.max(...list)], [v.now.scale.low, v.now.scale.high], [...v.numbers.children].map((e) => Number(e.textContent.replace("\u2212", "-")))]; })()""")
    check("the colours end at the least and the largest value", range_of == scale, (range_of, scale))
    check("the bar has the largest number on top", abs(numbers[0] - scale[1]) < 1e-3 * abs(scale[1]) and abs(numbers[-1] - scale[0]) < 1e-3 * abs(scale[1]) and numbers == sorted(numbers, reverse=True), numbers)
    off = browser.run("""(async () => { const v = document.body.viewer, { points, painter } = v; let worst = 0, all = 0; const made = [], thing = painter.thing;
        painter.thing = (kind, p, ...more) => { if (kind === "dots") made.push(...p); return thing.call(painter, kind, p, ...more); };
        v.makeLaws(); painter.thing = thing;
        for (let i = 0; i < made.length; i += 3, ++all) {
          let least = Infinity;
          for (let k = 0; k < v.now.moved.length; k += 3) least = Math.min(least, Math.hypot(...[0, 1, 2].map((j) => v.now.moved[k + j] - made[i + j])));
          worst = Math.max(worst, least);
        }
        return [all, worst]; })()""")
    check("the points of laws are on the moved body", off[0] > 50 and off[1] < 1e-5, off)
    drawn, counted = browser.run("""(() => { const v = document.body.viewer, { painter } = v, { thing, draw } = painter, sizes = new Map(), out = {}, counts = {};
        painter.thing = (kind, p, ...more) => { const made = thing.call(painter, kind, p, ...more); if (kind === "dots") sizes.set(made, p.length / 3); return made; };
        painter.draw = (what, how, ...more) => { if (sizes.has(what)) out[how.colour.map((x) => Math.round(255 * x).toString(16).padStart(2, "0")).join("")] = sizes.get(what); return draw.call(painter, what, how, ...more); };
        v.now.laws[0].branch = v.now.laws[0].branch.map((_, i) => i % 3);
        v.makeLaws(); v.draw(); Object.assign(painter, { thing, draw });
        for (const law of v.now.laws) for (const b of law.branch || []) { const colour = branches[b][1].slice(1); counts[colour] = (counts[colour] || 0) + 1; }
        return [out, counts]; })()""")
    check("every branch has its colour and its points", drawn == counted and len(drawn) > 1, (drawn, counted))
    numbers_of = lambda words: [float(x.replace("\u2212", "-")) for x in re.findall(r"[\u2212-]?\d[\d.]*(?:e[\u2212+-]?\d+)?", words)]
    browser.run("(() => { const v = document.body.viewer; v.now.values = v.now.values.map((_, i) => 2 * v.points[3 * i] - 3 * v.points[3 * i + 1] + 0.5 * v.points[3 * i + 2]); })()")
    box = browser.run("(({ x, y, width, height }) => ({ x, y, width, height }))(document.body.viewer.canvas.getBoundingClientRect())")
    for across, down in ((0.5, 0.5), (0.42, 0.55), (0.61, 0.47)):
        browser.mouse("mousePressed", box["x"] + across * box["width"], box["y"] + down * box["height"], button="left", clickCount=1)
        browser.mouse("mouseReleased", box["x"] + across * box["width"], box["y"] + down * box["height"], button="left", clickCount=1)
        words = browser.run("document.body.viewer.probed.textContent")
        x, y, z, value = (numbers_of(words) + 4 * [1e9])[:3] + [numbers_of(words)[-1]]
        check("a click tells the place on the body at rest and the value there", abs(2 * x - 3 * y + 0.5 * z - value) < 2e-3 and words.startswith("at ("), words)
    weights = browser.run("hit([0, 1, 2], Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), 0.2, 0.3).weights")
    check("a place in a triangle is what its corners make of it", all(abs(a - b) < 1e-6 for a, b in zip(weights, (0.5, 0.2, 0.3), strict=True)), weights)
    for place in ((2, 0, 1), (0, 1, 0), (1, 0, 0.5)):
        browser.run(f"document.body.viewer.probeAt({list(place)})")
        found = numbers_of(browser.run("document.body.viewer.probed.textContent"))
        check("a typed place is the one that is read", found[:3] == list(map(float, place)) and abs(found[-1] - (2 * place[0] - 3 * place[1] + 0.5 * place[2])) < 1e-4, (place, found))
    # Seen from the front, a field linear in x: dark lines where it is a multiple of a 16th of its range.
    levels = browser.run("""(async () => { const v = document.body.viewer; Object.assign(v.state, { factor: 0, contours: 16, forces: false, dots: false, mesh: false });
        await v.update(); v.now.values = v.now.values.map((_, i) => v.points[3 * i]); v.now.scale = { low: 0, high: 2, list: "viridis", from: 0, to: 2 }; v.makeSurface();
        v.view.turn = [0, 0]; v.draw();
        const c = document.createElement("canvas"); c.width = v.canvas.width; c.height = v.canvas.height; const context = c.getContext("2d"); context.drawImage(v.canvas, 0, 0);
        const row = Math.round(0.43 * c.height), d = context.getImageData(0, row, c.width, 1).data, light = (i) => d[4 * i] + d[4 * i + 1] + d[4 * i + 2], { scale } = v.scale(), out = [];
        for (let i = 4; i + 4 < c.width; ++i) {
          const x = v.centre[0] + (2 * (i + 0.5) / c.width - 1) / scale[0];
          if (x > 0.08 && x < 1.92 && light(i) < 0.8 * light(i - 4) && light(i) < 0.8 * light(i + 4) && light(i) <= light(i - 1) && light(i) < light(i + 1)) out.push(8 * x);
        }
        v.reset(); v.state.contours = 0; await v.update(); return out; })()""")
    check("contours are at 16ths of the range", len(levels) >= 10 and all(abs(level - round(level)) < 0.15 for level in levels), levels)
    values = browser.run("""(() => { const svg = document.querySelector("#tables svg"), box = svg.getBoundingClientRect(), out = [];
        for (const k of [0, 1, 2, 3, 4]) { // t = 0.2 (k + 1), from 78 to 624 of 640
          svg.dispatchEvent(new PointerEvent("pointermove", { clientX: box.left + box.width * (78 + 546 * k / 4 + 20) / 640, clientY: box.top + 20, bubbles: true }));
          out.push([document.querySelector("#tables output").textContent, document.body.viewer.state.frame]);
        }
        return out; })()""")
    check("the pointer reads the row next to it", all(words.startswith(f"t = {0.2 * (k + 1):.1g}:") for k, (words, _) in enumerate(values)), values)
    for k in (1, 3):
        browser.run(f"document.dispatchEvent(new CustomEvent('show-time', {{ detail: {0.2 * (k + 1) + 0.05} }}))")
        browser.wait(f"document.body.viewer.state.frame === {k}", 5)
    invariants = browser.run("quantitiesOf({ name: 's', components: 9 }, { dim: 2 }).slice(0, 3).map(([name, read]) => [name, read(Float64Array.of(5, 2, 0, 2, 1, 0, 0, 0, 0), 0)])")
    check("principal values in the plane", all(abs(value - wanted) < 1e-12 for (_, value), wanted in zip(invariants, (3 + 8 ** 0.5, 3 - 8 ** 0.5, 8 ** 0.5))), invariants)
    ranges = browser.run("""(async () => { const v = document.body.viewer, all = []; v.ranges = new Map();
        for (let f = 0; f < 5; ++f) all.push(...await v.valuesOf(f)); return [await v.rangeOfAll(), [Math.min(...all), Math.max(...all)]]; })()""")
    check("colours of all times end at the values of all", ranges[0] == ranges[1], ranges)


def numbers(browser):
    """The tables of work and of seconds have their own numbers; long numbers find room; what has no neighbour on a curve is a dot."""
    rows = browser.run("""(() => [...document.querySelectorAll("#plan table")].map((t) => [t.caption.textContent, [...t.tBodies[0].rows].map((r) => [...r.cells].map((c) => c.textContent))]))()""")
    tables = {caption: {line[0]: line[1] for line in lines} for caption, lines in rows}
    for caption, of in (("Work", "plan"), ("CPU time", "timing")):
        wanted = browser.run(f"text(report.result.{of}.sweeps)")
        check(f"sweeps of {caption}", tables.get(caption, {}).get("sweeps") == wanted, (tables.keys(), wanted))
    for number, words in (("6e9", "6e9"), ("-1234567", "\u22121.235e6"), ("-1.5e-16", "\u22121.5e\u221216"), ("999999", "1e6"), ("12345", "12350"), ("0", "0"), ("NaN", "\u2013")):
        check("numbers", browser.run(f"text({number})") == words, (number, browser.run(f"text({number})")))
    for points, dots in (("[[1, 2]]", 1), ("[[1, 2], [2, 3]]", 0), ("[[1, 2], [2, 3], [NaN, 0], [4, 1]]", 1), ("[[NaN, 1]]", 0), ("[[0, 1], [1, NaN], [2, 1], [3, NaN], [4, 1]]", 3)):
        found = browser.run(f"curveMarks({points}, (x, y) => [x, y], 'red').filter((e) => e.tagName === 'circle').length")
        check("dots of curves", found == dots, (points, found))
    check("the inequality is seen as a whole", browser.run("(({ scrollHeight, clientHeight }) => scrollHeight <= clientHeight + 2)(document.querySelector('.problem'))"))


def tab(browser, back=False):
    for kind in ("rawKeyDown", "keyUp"):
        browser("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9, modifiers=8 if back else 0)


HERE = """(() => { const e = document.activeElement, all = window.stops, b = e.getBoundingClientRect(), style = getComputedStyle(e);
    const covered = document.querySelector("nav").getBoundingClientRect().bottom;
    return { at: all.indexOf(e), seen: b.width > 0 && b.bottom > 0 && b.top < innerHeight, free: e.closest("nav, .skip") !== null || b.top >= covered - 4 || b.height > innerHeight - covered || b.bottom > covered + 60,
             ring: style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2, what: e.outerHTML.slice(0, 80) }; })()"""


def keyboard(browser):
    """Tab goes through all that can be used, in the order of the page, and out of it again; what has the focus is seen, below the menu, with a ring."""
    browser("Page.reload")
    browser.wait("!window.stops && document.body && document.body.dataset.ready === 'yes'")
    browser.run("""window.stops = [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex='0']")].filter((e) => e.getClientRects().length && !e.disabled);
""")
    n = browser.run("window.stops.length")
    check("there is something to walk through", n > 40, n)
    for k in range(n):
        tab(browser)
        here = browser.run(HERE)
        if not check(f"Tab {k} is at its place, seen and marked", here["at"] == k and here["seen"] and here["free"] and here["ring"], here):
            break
    tab(browser)
    check("Tab leaves the page at its end", browser.run("window.stops.indexOf(document.activeElement)") in (-1, 0), browser.run(HERE))
    browser.run("window.stops[5].focus()")
    tab(browser, back=True)
    check("shift and Tab go back", browser.run(HERE)["at"] == 4, browser.run(HERE))
    browser.run("document.querySelector('.skip').focus()")
    check("the link to the content is seen when it has the focus", browser.run("document.activeElement.getBoundingClientRect().left") >= 0)
    browser.key("Enter")
    browser.wait("document.activeElement.id === 'content'")
    tab(browser)
    check("behind it Tab goes on in the content", browser.run("document.querySelector('main').contains(document.activeElement)"))
    hidden = browser.run("""(() => { const out = [];
        for (const link of document.querySelectorAll("nav a")) {
          link.click();
          const heading = document.querySelector(link.hash).querySelector("h2") || document.querySelector(link.hash);
          const top = heading.getBoundingClientRect().top, below = document.querySelector("nav").getBoundingClientRect().bottom;
          if (!(top >= below && top < innerHeight)) out.push([link.hash, top, below]);
        }
        return out; })()""")
    check("a link of the menu shows its heading, below the menu", not hidden, hidden)
    browser.run("document.getElementById('play').focus()")
    for _ in range(2):  # plays, stops
        before = browser.run("document.body.viewer.playing || false")
        browser.key("Enter")
        check("Enter plays and stops", browser.run("document.body.viewer.playing") != before)
    browser.run("document.getElementById('time').focus(); document.body.viewer.show(2)")
    browser("Input.dispatchKeyEvent", type="rawKeyDown", key="ArrowRight", code="ArrowRight", windowsVirtualKeyCode=39)
    browser.wait("document.body.viewer.state.frame === 3")


ROLES = {"button", "slider", "checkbox", "combobox", "spinbutton", "link", "image", "application", "textbox", "region", "navigation", "table", "DisclosureTriangle", "figure"}


def screen_reader(browser):
    """What a reader of screens is given: every part has a role and a name, landmarks and headings are in order, values of curves are told."""
    browser("Accessibility.enable")
    nodes = [node for node in browser("Accessibility.getFullAXTree")["nodes"] if not node.get("ignored")]
    role = lambda node: node.get("role", {}).get("value", "")
    name = lambda node: (node.get("name", {}).get("value") or "").strip()
    unnamed = [role(node) for node in nodes if role(node) in ROLES - {"table", "figure"} and not name(node)]
    check("everything that can be used has a name", not unnamed, unnamed)
    roles = {role(node) for node in nodes}
    check("landmarks", {"banner", "navigation", "main", "heading", "application", "slider", "checkbox", "combobox", "spinbutton", "button", "table"} <= roles, roles)
    levels = [next(p["value"]["value"] for p in node["properties"] if p["name"] == "level") for node in nodes if role(node) == "heading"]
    check("headings go down by one", levels[0] == 1 and levels.count(1) == 1 and all(b <= a + 1 for a, b in zip(levels, levels[1:])), levels)
    check("the language is said", browser.run("document.documentElement.lang") == "en")
    browser.run("document.querySelector('#tables svg').focus()")
    browser.key("End")
    told = browser.run("document.querySelector('#tables svg').getAttribute('aria-valuetext')")
    check("a curve tells its values", "t = 1" in told and "a = " in told, told)
    browser("Accessibility.disable")


def curves(browser):
    first = "document.querySelector('#tables svg')"
    browser.run(f"{first}.focus()")
    browser.key("End")
    check("keys move the cursor of a curve", "t = 1" in browser.run("document.querySelector('#tables output').textContent"))
    browser.wait("document.body.viewer.state.frame === 4")
    browser.key("Home")
    browser.wait("document.body.viewer.state.frame === 0")  # the body follows
    browser.run("document.querySelector('#tables details summary').click()")
    browser.wait("document.querySelectorAll('#tables details table tbody tr').length === 5")
    check("no value is shown as what it is not", not browser.run("document.body.innerText.match(/\\[object|undefined|NaN/)"))
    check("every section is in the menu", browser.run("[...document.querySelectorAll('main section')].every((s) => document.querySelector(`nav a[href='#${s.id}']`))"))
    unnamed = browser.run("""[...document.querySelectorAll("canvas:not([aria-hidden]), svg, input, select, button")].filter((e) =>
        !e.getAttribute("aria-label") && !e.closest("label") && !e.textContent.trim()).map((e) => e.outerHTML.slice(0, 90))""")
    check("everything has a name for readers of screens", not unnamed, unnamed)
    check("mathematics is drawn", browser.run("document.querySelector('#model math').getBoundingClientRect().height") > 60)
    pages = base64.b64decode(browser("Page.printToPDF", printBackground=True)["data"])
    check("it prints", pages.startswith(b"%PDF") and len(pages) > 20000, len(pages))


def units(browser, folder):
    """The same with units: they stand behind what is shown."""
    (folder / "measured.hvi").write_text(MEASURED)
    done = subprocess.run([PROGRAM, "report", "measured.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    browser("Page.navigate", url=(folder / "out/measured_report.html").as_uri())
    browser.wait("document.title === 'measured: report' && document.body.dataset.ready === 'yes'")
    browser.shot("measured", whole=True)
    shown = browser.run("document.body.innerText")
    for words in ("tip [mm]", "pressed [MPa]", "Energies [N]", "layer: ξ [MPa]", "t = 10 [s]", "pressed [MPa] against tip [mm]"):
        check(f"{words} is shown", words in shown or words in browser.run("[...document.querySelectorAll('figcaption')].map((e) => e.textContent).join('|')"))
    axes = browser.run("[...document.querySelectorAll('svg text')].map((e) => e.textContent)")
    check("axes of time and of a law have units", "t [s]" in axes and "r [mm]" in axes, [a for a in axes if "[" in a])
    browser.run("document.body.viewer.probeAt([20, 10, 0])")
    check("the bar has the unit", browser.run("document.body.viewer.barName.textContent").endswith(" [MPa]"))
    check("a probe has units", re.fullmatch(r"at \(20, 10\) \[mm\]: .* \[MPa\]", browser.run("document.body.viewer.probed.textContent")), browser.run("document.body.viewer.probed.textContent"))
    check("the canvas tells units", "[MPa], at t = 10 [s]" in browser.run("document.body.viewer.canvas.getAttribute('aria-label')"))
    check("nothing undefined with units", not re.search(r"\[object|undefined|NaN", shown))


def bar(browser, folder):
    """A body in one dimension: curves over its length at the time of a slider, which plays."""
    (folder / "bar.hvi").write_text(BAR)
    done = subprocess.run([PROGRAM, "report", "bar.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    browser("Page.navigate", url=(folder / "out/bar_report.html").as_uri())
    browser.wait("document.title === 'bar: report' && document.body.dataset.ready === 'yes'")
    end = """(() => { const svg = document.querySelector('#fields svg'); svg.focus(); svg.dispatchEvent(new KeyboardEvent("keydown", { key: "End" }));
        return [document.querySelector("#fields figcaption").textContent, svg.getAttribute("aria-valuetext")]; })()"""
    told = browser.run("report.result.table")
    title, value = browser.run(end)
    last = told["a"][-1]
    check("a bar at its last time", title == "u at t = 2" and abs(float(value.split("u = ")[1].replace("\u2212", "-")) - last) < 1e-5 * abs(last), (title, value, last))
    browser.run("""(() => { const e = document.getElementById("time"); e.value = 1; e.dispatchEvent(new Event("input", { bubbles: true })); })()""")
    browser.wait("document.querySelector('#fields figcaption').textContent === 'u at t = 1'")
    title, value = browser.run(end)
    check("a bar at a time that is chosen", abs(float(value.split("u = ")[1].replace("\u2212", "-")) - told["a"][1]) < 1e-5 * abs(last), (title, value, told["a"]))
    browser.run("document.getElementById('play').click()")
    browser.wait("document.querySelector('#fields figcaption').textContent === 'u at t = 2'")
    browser.run("document.getElementById('play').click()")
    check("it stops", browser.run("document.getElementById('play').textContent") == "play")


def worn(browser, folder):
    """A field that a part alone has: grey elsewhere, in the range of what there is; a click says so."""
    (folder / "worn.hvi").write_text(WORN)
    done = subprocess.run([PROGRAM, "report", "worn.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    browser("Page.navigate", url=(folder / "out/worn_report.html").as_uri())
    browser.wait("document.title === 'worn: report' && document.body.dataset.ready === 'yes'")
    at = browser.run("document.body.viewer.quantities.findIndex((q) => q.name === 'd')")
    browser.set("quantity", at)
    low, high = browser.run("[document.body.viewer.now.scale.low, document.body.viewer.now.scale.high]")
    check("the range of a field of a part", 0 <= low < high <= 0.95, (low, high))
    browser.set("contours", 16)
    grey = browser.run("""(() => { const v = document.body.viewer, small = document.createElement("canvas"); small.width = v.canvas.width; small.height = v.canvas.height;
        const c = small.getContext("2d"); c.drawImage(v.canvas, 0, 0); const d = c.getImageData(0, 0, small.width, small.height).data; let grey = 0, coloured = 0;
        for (let i = 0; i < d.length; i += 4) { const s = Math.max(d[i], d[i + 1], d[i + 2]) - Math.min(d[i], d[i + 1], d[i + 2]);
          if (s > 60) ++coloured; else if (s < 14 && d[i] > 90 && d[i] < 240) ++grey; }
        return [grey, coloured]; })()""")
    check("grey where there is no value, colours where there is", min(grey) > 0.25 * max(grey), grey)
    browser.run("document.body.viewer.probeAt([2, 1, 1])")
    check("a probe says that there is no value", browser.run("document.body.viewer.probed.textContent").endswith("d = \u2013"), browser.run("document.body.viewer.probed.textContent"))
    browser.set("cut", "z")
    check("a cut of it", browser.run("document.body.viewer.cap.count") > 0)
    browser.set("fixed", True)
    check("colours of all times of it", browser.run("Number.isFinite(document.body.viewer.now.scale.low)"))
    browser.run("document.getElementById('fields').scrollIntoView()")
    browser.shot("worn")


PAGES = """param order = P1
param tip = 2
mesh bar = interval(1, cells = 8)
part left = bar.left
space V = scalar order on bar, zero on left
find u in V for t in [0, 1] by 4 steps from u = 0 such that for all v in V
  integral(bar, dot(grad(u), grad(v))) + integral(bar, u'*v) = integral(bar, tip*t*v)
report
  table tip = u at [1]
study vary order in [P1, P2] and tip in [1, 2]"""


def pages(browser, folder):
    """Pages of studies and of stability: parameters, columns and what every setting has stand apart, whatever they are called."""
    rows = """(() => { const [head, ...body] = [...document.querySelectorAll("#study table tr")].map((r) => [...r.cells].map((c) => c.textContent)); return [head, body]; })()"""
    for end in ("", " against finest"):
        (folder / "study.hvi").write_text(PAGES + end + "\n")
        for command in ("study", "stability"):
            done = subprocess.run([PROGRAM, command, "study.hvi", "--report", "-o", "pages"], cwd=folder, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            page, = (folder / "pages").glob("*.html")
            browser("Page.navigate", url=page.as_uri())
            browser.wait("document.body && document.body.dataset.ready === 'yes'")
            page.unlink()
            if command == "stability":
                words = browser.run("document.getElementById('stability').textContent")
                check("a page of stability draws its steps", "null" not in words and "[0" not in words and browser.run("document.querySelectorAll('#stability svg').length") == 1, words[:600])
                continue
            head, body = browser.run(rows)
            said = browser.run("document.querySelector('#study p').textContent")
            check("heads of a study", head[:3] == ["order", "tip", "tip"] and ("observed order" in head) == bool(end) and ("front" in head) == bool(end), head)
            check("values of a study", [line[:2] for line in body] == [["P1", "1"], ["P1", "2"], ["P2", "1"], ["P2", "2"]] and all(float(line[2]) > 0.1 for line in body), body)
            check("what a study is held against", ("Errors against" in said) == bool(end), said)


def main():
    program = chromium()
    if program is None:
        print("skipped: there is no Chromium (apt-get install chromium)")
        sys.exit(77)
    looks = {} if NEW else json.loads(LOOKS.read_text())
    with tempfile.TemporaryDirectory() as place:
        folder = pathlib.Path(place)
        (folder / "scene.hvi").write_text(SCRIPT)
        done = subprocess.run([PROGRAM, "report", "scene.hvi", "-o", "out"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        held = [os.open(os.devnull, os.O_RDONLY)]  # until files of the browser's start get the numbers that those of a fourth browser got
        while held[-1] < 8:
            held.append(os.open(os.devnull, os.O_RDONLY))
        browser = Browser(program, folder / "profile", SHOTS)
        try:
            browser("Page.navigate", url=(folder / "out/scene_report.html").as_uri())
            browser.wait("document.body && document.body.dataset.ready === 'yes'")
            browser.shot("report", whole=True)
            viewer(browser, looks)
            curves(browser)
            geometry(browser)
            told(browser)
            numbers(browser)
            keyboard(browser)
            screen_reader(browser)
            units(browser, folder)
            bar(browser, folder)
            worn(browser, folder)
            pages(browser, folder)
            check("no error, no request", not browser.errors, browser.errors)
        finally:
            browser.close()
            list(map(os.close, held))
    if NEW:
        LOOKS.write_text(json.dumps(looks, separators=(",", ":")) + "\n")
    print("browser:", "ok" if failures == 0 else f"{failures} failures")
    sys.exit(failures > 0)


main()
