"""Families of problems whose data jump, pulse, oscillate or have layers in time, for --accuracy.

A family is a kind of data times a kind of scene. The scenes are bars pulled at an end: their strain is the same
everywhere, so that the solution is that of one equation,

    a W' + b W + c int_0^s exp(-(s - r)/q) W(r) dr + dj(W + G(s)) contains f(s),     s = (t - t0)/T,

which is solved here by brute force (a stiffly accurate DIRK method of second order on steps that hit all breaks and crowd
after them), with no code of the program; and bodies that conduct heat with a known solution. Numbers, times and targets are
drawn with a seed.
"""
import bisect
import math

PI = math.pi


# ---- data: text in s(), the same function in Python, its breaks and time scales --------------------------------------

class Data:
    def __init__(self, text, value, breaks=(), scale=1.0):
        self.text, self.value, self.breaks, self.scale = text, value, sorted(breaks), scale


def jump(d):
    a, v = d.uniform(0.1, 0.9), d.uniform(-0.5, 2)
    return Data(f"| s() < {a:.6g} -> 1 | otherwise -> {v:.6g}", lambda s, a=float(f"{a:.6g}"), v=float(f"{v:.6g}"): 1.0 if s < a else v, [float(f"{a:.6g}")])


def steps_up(d):
    cuts = sorted(float(f"{d.uniform(0.03, 0.97):.6g}") for _ in range(3))
    values = [float(f"{d.uniform(-1, 1.5):.6g}") for _ in range(4)]
    text = " ".join(f"| s() < {c} -> {v}" for c, v in zip(cuts, values)) + f" | otherwise -> {values[3]}"
    return Data(text, lambda s: values[bisect.bisect_right(cuts, s)], cuts)


def pulse(d, length=None):
    length = float(f"{length or d.uniform(0.02, 0.06):.6g}")
    a, base = float(f"{d.uniform(0.1, 0.85):.6g}"), float(f"{d.uniform(0, 0.3):.6g}")
    end = a + length
    return Data(f"{base} + pulse(s(), {a}, {length})", lambda s: base + (1.0 if a <= s < end else 0.0), [a, end], length)


def short_pulse(d):
    return pulse(d, 10 ** d.uniform(-3.5, -2))


def impact(d):
    a, length = float(f"{d.uniform(0.1, 0.85):.6g}"), float(f"{d.uniform(0.01, 0.1):.6g}")
    return Data(f"0.1 + half_sine(s(), {a}, {length})",
                lambda s: 0.1 + (math.sin(PI * (s - a) / length) if a <= s < a + length else 0.0), [a, a + length], length)


def kink(d):
    a = float(f"{d.uniform(0.1, 0.9):.6g}")
    return Data(f"abs(s() - {a})", lambda s: abs(s - a), [a])


def hold(d):
    a, b = sorted(float(f"{d.uniform(0.02, 0.98):.6g}") for _ in range(2))
    return Data(f"ramp(s(), {a}) - 0.7*ramp(max(s() - {b}, 0), 0.02)",
                lambda s: min(max(s / a, 0), 1) - 0.7 * min(max(max(s - b, 0) / 0.02, 0), 1), [a, b, b + 0.02], 0.02)


def wave(d):
    w = float(f"{d.uniform(25, 60):.6g}")
    return Data(f"sin({w}*s())", lambda s: math.sin(w * s), scale=1 / w)


def beat(d):
    w, v = float(f"{d.uniform(25, 60):.6g}"), float(f"{d.uniform(2, 5):.6g}")
    return Data(f"sin({w}*s())*cos({v}*s()) + 0.4*s()", lambda s: math.sin(w * s) * math.cos(v * s) + 0.4 * s, scale=1 / w)


def triangle(d):
    p = float(f"{1 / d.uniform(2, 9):.6g}")
    tops = [p * (0.25 + 0.5 * k) for k in range(40)]
    return Data(f"triangle(s(), {p})", lambda s: 2 / PI * math.asin(math.sin(2 * PI * s / p)), tops, p / 4)


def square(d):
    w = float(f"{d.uniform(8, 40):.6g}")
    return Data(f"0.3 + sign(sin({w}*s()))", lambda s: 0.3 + math.copysign(1.0, math.sin(w * s)) if s > 0 else 0.3,
                [PI * k / w for k in range(1, 40)], PI / w)


def decay(d):
    r = float(f"{10 ** d.uniform(1.5, 3):.6g}")
    return Data(f"0.2*s() + exp(-{r}*s())", lambda s: 0.2 * s + math.exp(-r * s), scale=1 / r)


def rise(d):
    r = float(f"{10 ** d.uniform(1.5, 3):.6g}")
    return Data(f"1 - exp(-{r}*s())", lambda s: 1 - math.exp(-r * s), scale=1 / r)


def peak(d):
    a, w = float(f"{d.uniform(0.1, 0.9):.6g}"), float(f"{10 ** d.uniform(-3.5, -1.5):.6g}")
    return Data(f"0.2 + exp(-((s() - {a})/{w})^2)", lambda s: 0.2 + math.exp(-((s - a) / w) ** 2), [a - 4 * w, a, a + 4 * w], w)


def front(d):
    a, w = float(f"{d.uniform(0.1, 0.9):.6g}"), float(f"{10 ** d.uniform(-4, -2):.6g}")
    return Data(f"1 + 0.8*tanh((s() - {a})/{w})", lambda s: 1 + 0.8 * math.tanh((s - a) / w), [a - 10 * w, a, a + 10 * w], w)


def sudden(d):
    v = float(f"{d.uniform(0.3, 2):.6g}")
    return Data(f"{v}", lambda s: v)


def clipped(d):
    w, m = float(f"{d.uniform(8, 30):.6g}"), float(f"{d.uniform(0.3, 0.8):.6g}")
    first = math.asin(m) / w
    breaks = [x + PI * k / w for k in range(20) for x in (first, PI / w - first)]
    return Data(f"min(max(sin({w}*s()), -{m}), {m})", lambda s: min(max(math.sin(w * s), -m), m), breaks, first)


DATA = {f.__name__: f for f in (jump, steps_up, pulse, short_pulse, impact, kink, hold, wave, beat, triangle, square, decay,
                                rise, peak, front, sudden, clipped)}


# ---- laws: pieces (up to r, value at the piece's lower end or at 0, slope) as text and for the reference -----------------

class Law:
    """Slope of j by pieces: ends r_1 < r_2 < ..., and (value at anchor, anchor, slope) for each piece."""

    def __init__(self, ends, pieces):
        self.ends, self.pieces = ends, pieces

    def text(self):
        cases = [f"({v:.9g}) + ({k:.9g})*(r - ({x:.9g}))" for v, x, k in self.pieces]
        if not self.ends:
            return cases[0]
        return " ".join(f"| r < {e:.9g} -> {c}" for e, c in zip(self.ends, cases)) + f" | otherwise -> {cases[-1]}"

    def at(self, piece, r):
        v, x, k = self.pieces[piece]
        return v + k * (r - x)

    def state(self, r):
        """Which piece holds r, or which corner."""
        i = bisect.bisect_right(self.ends, r)
        near = [k + 0.5 for k, e in enumerate(self.ends) if abs(r - e) < 1e-12]
        return near[0] if near else i

    def solve(self, alpha, beta, offset):
        """W with alpha W + dj(W + offset) containing beta; alpha is larger than any descent."""
        best = None
        for i in range(len(self.pieces)):
            low = self.ends[i - 1] if i else -math.inf
            high = self.ends[i] if i < len(self.ends) else math.inf
            v, x, k = self.pieces[i]
            r = (beta - v + k * x + alpha * offset) / (alpha + k)
            if low <= r <= high:
                return r - offset
            if i < len(self.ends):
                left, right = self.at(i, high), self.at(i + 1, high)
                need = beta - alpha * (high - offset)
                if left <= need <= right:
                    return high - offset
                gap = min(abs(need - left), abs(need - right))
                if best is None or gap < best[0]:
                    best = (gap, high - offset)
        return best[1]  # rounding at a corner


def free(d, size):
    return Law([], [(0.0, 0.0, 0.0)])


def spring(d, size):
    g, k = float(f"{size * d.uniform(0.1, 0.5):.6g}"), float(f"{d.uniform(2, 20):.6g}")
    return Law([g], [(0.0, 0.0, 0.0), (0.0, g, k)])


def softening(d, size):
    g = float(f"{size * d.uniform(0.1, 0.3):.6g}")
    return Law([0.0, g, 2 * g], [(0.0, 0.0, 0.0), (0.0, 0.0, 3.0), (3 * g, g, -0.5), (2.5 * g, 2 * g, 0.0)])


def stop(d, size):
    """The slope jumps up: what is pulled against it stands still for a while."""
    g, v = float(f"{size * d.uniform(0.05, 0.4):.6g}"), float(f"{d.uniform(0.1, 0.5):.6g}")
    return Law([g], [(0.0, 0.0, 0.2), (0.2 * g + v, g, 0.5)])


def friction(d, size):
    v = float(f"{d.uniform(0.05, 0.3):.6g}")
    return Law([0.0], [(-v, 0.0, 0.0), (v, 0.0, 0.0)])


# ---- scenes -----------------------------------------------------------------------------------------------------------

HEAD = """import loads
fn s() = (t - {t0})/{T}
fn g() = {data}
mesh bar = interval(1, cells = 4)
part left = bar.left
part right = bar.right
superpotential p(r) with slope {law}
{kernel}space V = scalar P1 on bar, zero on left
"""
BAR = """find u in V{imposed} for t in [{t0}, {end}] by 4096 steps from u = {initial}
such that for all v in V
{forms}
  + integral(right, p^0(u; v))
 >= {load}
report
  table tip = u at [1], stretch = {stretch}
"""


class Scene:
    """One problem: script, column or V to be reached, and the reference's equation."""

    def __init__(self, name, script, probe, wanted, error):
        self.name, self.script, self.probe, self.wanted, self.true_error = name, script, probe, wanted, error


def bar(d, name, data, law, a, c, imposed=False):
    T = float(f"{10 ** d.uniform(-2, 2):.4g}")
    t0 = float(f"{d.choice([0, 0, d.uniform(-1, 1)]) * T:.4g}")
    b, q = 1.0, float(f"{10 ** d.uniform(-1.5, 0):.4g}")
    f = data(d)
    law = law(d, 0.5)
    head = HEAD.format(t0=t0, T=T, data=f.text, law=law.text(),
                       kernel=f"kernel C(lag) = {c / T:.12g}*exp(-lag/{q * T:.12g})\n" if c else "")
    forms = ["    integral(bar, dot(grad(u), grad(v)))"]
    if a:
        forms.insert(0, f"    integral(bar, {a * T:.12g}*dot(grad(u'), grad(v)))")
    if c:
        forms.append("    integral(bar, dot(history(C, grad(u)), grad(v)))")
    script = head + BAR.format(
        imposed=" with u = g() on left" if imposed else "", initial=f"{f.value(0.0):.17g}" if imposed else "0", t0=t0,
        end=f"{t0 + T:.17g}", forms="\n  + ".join(x.strip() for x in forms), stretch="integral(bar, grad(u).x)",
        load="0" if imposed else "integral(right, g()*v)")
    probe = d.choice(["", "tip"])
    wanted = d.choice([1e-2, 3e-3, 1e-3])

    def error(result):
        times = [(t - t0) / T for t in result["table"]["t"]]
        exact = solve(a, b, c, q, law, f, imposed, times)
        column = "stretch" if probe == "" else probe
        shown = [w + (f.value(s) if imposed and probe else 0.0) for w, s in zip(exact, times)]
        size = max(map(abs, shown))
        return max(abs(x - y) for x, y in zip(result["table"][column], shown)) / size

    return Scene(name, script, probe, wanted, error)


def grid_for(f, a, rate, count=6000):
    """Steps that hit the breaks, crowd after them, and are short against the data's scale."""
    edges = [0.0] + [x for x in f.breaks if 1e-12 < x < 1 - 1e-12] + [1.0]
    out = [0.0]
    for low, high in zip(edges, edges[1:]):
        n = max(40, int(count * (high - low)), min(4 * count, int(40 * (high - low) / f.scale)))
        crowd = []
        if a or rate:
            x = 1e-7
            while x < (high - low) / n * 8:
                crowd.append(low + x)
                x *= 1.08
        first = crowd[-1] if crowd else low
        out += crowd + [first + (high - first) * k / n for k in range(1, n)] + [high]
    return out


def solve(a, b, c, q, law, f, imposed, times):
    """W at the times: DIRK with gamma = 1 - 1/sqrt 2 for (W, m), m' = W - m/q; without a, W from m at each time."""
    gamma = 1 - 1 / math.sqrt(2)

    def force(s):
        return 0.0 if imposed else f.value(s)

    def offset(s):
        return f.value(s) if imposed else 0.0

    grid = sorted({*grid_for(f, a, c), *(s for s in times if 0 < s < 1)})  # read between steps it would be affine
    W, m = 0.0, 0.0
    values, memories = [W], [m]

    def stage(s, k, w0, m0):
        # a (W - w0)/k + b W + c m + dj(W + G) = f,  m = (m0 + k W)/(1 + k/q)
        damp = 1 / (1 + k / q)
        w = law.solve((a / k if k else 0.0) + b + c * damp * k, force(s) - c * damp * m0 + (a / k * w0 if a else 0.0),
                      offset(s))
        return w, damp * (m0 + k * w)

    def step(begin, end, W, m):
        h = end - begin
        last = end - 1e-13 if end in hit else end  # the value before a jump
        w1, m1 = stage(begin + gamma * h, gamma * h, W, m)
        ratio = (1 - gamma) / gamma
        return stage(last, gamma * h, W + ratio * (w1 - W), m + ratio * (m1 - m))

    hit, shortest = set(f.breaks), 1e-9
    points, todo = [grid[0]], list(reversed(grid[1:]))
    while todo:
        begin, end = points[-1], todo[-1]
        w, memory = step(begin, end, W, m)
        # Where the law changes its piece, W' may jump: such steps are halved until they are nothing.
        before, after = law.state(W + offset(begin + 1e-13)), law.state(w + offset(end - 1e-13))
        if before != after and end - begin > shortest:
            todo.append(begin + 0.5 * (end - begin))
            continue
        todo.pop()
        W, m = w, memory
        points.append(end), values.append(W), memories.append(m)
    grid = points
    out = []
    for s in times:
        i = min(max(bisect.bisect_right(grid, s), 1), len(grid) - 1)
        part = (s - grid[i - 1]) / (grid[i] - grid[i - 1])
        if a:
            out.append(values[i - 1] + part * (values[i] - values[i - 1]))
        else:
            memory = memories[i - 1] + part * (memories[i] - memories[i - 1])
            out.append(law.solve(b, force(s) - c * memory, offset(s)))
    return out


def viscous(d, name, data):
    return bar(d, name, data, free, 10 ** d.uniform(-2.5, 0), 0.0)


def viscous_contact(d, name, data):
    return bar(d, name, data, d.choice([spring, softening]), 10 ** d.uniform(-2, -0.5), d.choice([0.0, 1.5]))


def fading(d, name, data):
    return bar(d, name, data, free, 0.0, d.uniform(0.5, 4))


def stopped(d, name, data):
    return bar(d, name, data, stop, 10 ** d.uniform(-2, -0.5), 0.0)


def rubbing(d, name, data):
    return bar(d, name, data, friction, d.choice([0.0, 0.05]), d.choice([0.0, 1.0]))


def driven(d, name, data):
    return bar(d, name, data, spring, 10 ** d.uniform(-2, -0.5), d.choice([0.0, 1.0]), imposed=True)


HEAT = """import loads
fn s() = (t - {t0})/{T}
fn g() = {g}
fn dg() = ({dg})/{T}
mesh bar = interval(1, cells = 8)
part ends = bar.boundary
space W = scalar P1 on bar, zero on ends
fn phi() = sin(pi*x)
find w in W for t in [{t0}, {end}] by 4096 steps from w = {start}*sin(pi*x)
such that for all q in W
    integral(bar, w' * q) + integral(bar, {k}*dot(grad(w), grad(q)))
  = integral(bar, (dg() + {k}*pi^2*g())*phi()*q)
report
  table middle = w at [0.5], error = sqrt(integral(bar, dot(grad(w) - g()*grad(phi()), grad(w) - g()*grad(phi())))),
        size = sqrt(integral(bar, g()*g()*dot(grad(phi()), grad(phi()))))
"""


def heat(d, name, data):
    """A known solution g(t) sin(pi x): its load has the kinks of g as jumps. Data that jump have no such solution."""
    a, w, r = (float(f"{x:.6g}") for x in (d.uniform(0.1, 0.9), d.uniform(25, 60), 10 ** d.uniform(1.5, 2.7)))
    width = float(f"{10 ** d.uniform(-2.5, -1):.6g}")
    kinds = {
        "kink": (f"abs(s() - {a})", f"sign(s() - {a})", a),
        "wave": (f"sin({w}*s())", f"{w}*cos({w}*s())", 0.0),
        "decay": (f"exp(-{r}*s())", f"-{r}*exp(-{r}*s())", 1.0),
        "rise": (f"1 - exp(-{r}*s())", f"{r}*exp(-{r}*s())", 0.0),
        "peak": (f"0.2 + exp(-((s() - {a})/{width})^2)", f"-2*(s() - {a})/{width}^2*exp(-((s() - {a})/{width})^2)",
                 0.2 + math.exp(-(a / width) ** 2)),
        "hold": (f"min(s()/{a}, 1)", f"pulse(s(), 0, {a})/{a}", 0.0),
        "triangle": (f"abs(s() - {a}) - 2*abs(s() - {0.7 * a:.9g})", f"sign(s() - {a}) - 2*sign(s() - {0.7 * a:.9g})",
                     a - 2 * float(f"{0.7 * a:.9g}")),
    }
    g, dg, start = kinds[data.__name__]
    T = float(f"{10 ** d.uniform(-1, 1):.4g}")
    t0 = float(f"{d.choice([0, 0, d.uniform(-1, 1)]) * T:.4g}")
    script = HEAT.format(g=g, dg=dg, start=f"{start:.17g}", t0=t0, T=T, end=f"{t0 + T:.17g}",
                         k=f"{10 ** d.uniform(-1.5, 0) / T:.9g}")

    def error(result):
        return max(result["table"]["error"]) / max(result["table"]["size"])

    return Scene(name, script, "", d.choice([3e-2, 1e-2, 3e-3]), error)


SCENES = {f.__name__: f for f in (viscous, viscous_contact, fading, stopped, rubbing, driven)}
HEATED = ("kink", "wave", "decay", "rise", "peak", "hold", "triangle")

#: (scene, data): every family; imposed values that jump from the start are left to the others.
FAMILIES = [(s, k) for s in SCENES for k in DATA if not (s == "driven" and k == "sudden")] + [("heat", k) for k in HEATED]


def scene(family, draw):
    kind, data = family
    name = f"{kind}, {data}"
    return heat(draw, name, DATA[data]) if kind == "heat" else SCENES[kind](draw, name, DATA[data])
