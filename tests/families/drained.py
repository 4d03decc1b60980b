"""A porous body that is loaded slowly follows the branch of the same body without water.

usage: drained.py HVI_RUN [--scenes N] [--seed S] [--only K] [--keep FOLDER]

A body in 2D or 3D, P2 and P1, with pore water that flows off through its roof, on a layer that softens faster than the body is stiff, and then
keeps a rest of its force. Its load grows far more slowly than water flows, and rests at the end. Reference (another problem, with one unknown): the elastic body
alone, under the same steps. Displacements and the force of the layer are the same after every step, to what the pressure still holds.
"""
import argparse
import pathlib
import sys
import tempfile

import numpy as np

from units import table

SAME = 1e-5  # of the largest value


def script(random, with_water):
    dim, cells = int(random.choice([2, 2, 3])), 2
    body = (f"rectangle(1, 0.5, cells = [{2 * cells}, {cells}])" if dim == 2 else f"box(1, 0.5, 0.5, cells = [{2 * cells}, {cells}, {cells}])")
    young, fall = 10 ** random.uniform(0.3, 1.5), 10 ** random.uniform(0, 2)
    peak, reach = random.uniform(1, 4), random.uniform(0.03, 0.1)
    load, permeability = random.uniform(0.5, 3), 10 ** random.uniform(-2, 0)
    water = (", p in Q", ", q in Q", ", p = 0", f"""
  - integral(body, p*div(v))
  + integral(body, div(u')*q)
  + integral(body, {permeability!r}*dot(grad(p), grad(q)))""", "\nspace Q = scalar P1 on body, zero on roof") if with_water else ("",) * 5
    point = "[1, 0.5]" if dim == 2 else "[1, 0.5, 0.25]"
    return f"""mesh body = {body}
part ground = body.bottom
part roof = body.top
part wall = body.left
tensor B = isotropic(young = {young!r}, poisson = 0.25)
superpotential layer(r) with slope
  | r < 0 -> 0
  | r < {reach!r} -> {peak / reach!r}*r
  | otherwise -> {peak!r} - min({fall!r}*(r - {reach!r}), {0.8 * peak!r})
space V = vector P2 on body, zero on wall{water[4]}
find u in V{water[0]} for t in [0, 4e5] by {int(random.integers(3, 20))} steps from u = 0{water[2]}
such that for all v in V{water[1]}
    integral(body, B : eps(u) : eps(v)){water[3]}
  + integral(ground, layer^0(u.nu; v.nu))
 >= integral(roof, -{load!r}*min(1, t/3e5)*v.y)
report
  table down = u.y at {point}, push = integral(ground, layer.xi)
"""


def main():
    parse = argparse.ArgumentParser()
    parse.add_argument("program", type=pathlib.Path)
    parse.add_argument("--scenes", type=int, default=20)
    parse.add_argument("--seed", type=int, default=1)
    parse.add_argument("--only", type=int)
    parse.add_argument("--keep", type=pathlib.Path)
    words = parse.parse_args()
    program, wrong, softened = words.program.resolve(), 0, 0
    for k in range(words.scenes) if words.only is None else [words.only]:
        with tempfile.TemporaryDirectory() as name:
            folder = words.keep or pathlib.Path(name)
            dry, wet = (table(program, folder, which, script(np.random.default_rng([words.seed, k]), which == "wet"), "direct") for which in ("dry", "wet"))
        if isinstance(dry, str) or isinstance(wet, str):
            wrong += 1
            print(f"scene {k}: refused: dry {dry if isinstance(dry, str) else 'solved'}; wet {wet if isinstance(wet, str) else 'solved'}")
            continue
        softened += bool(np.any(np.diff(dry["push"]) < 0))
        apart = max(np.abs(wet[column] - dry[column]).max() / np.abs(dry[column]).max() for column in ("down", "push"))
        if apart > SAME:
            wrong += 1
            print(f"scene {k}: the porous body is {apart:.1e} from the dry one")
    print(f"{words.scenes} scenes, {softened} with forces that fell; {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
