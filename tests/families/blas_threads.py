"""Random scenes with several threads of OpenBLAS against one, by factors of all kinds.

usage: blas_threads.py HVI_RUN [--scenes N] [--seed S]

Where OpenBLAS is its serial build, which the program takes at most, an option for threads is told to have no effect, and the bits are the same.
Where the build for threads is installed beside it (or in the folder HVI_THREADED_BLAS) runs take it: every number of the table agrees to 1e-9
of its column's largest value, all runs are certified, and the same number of threads has the same bits each time.
"""
import argparse
import glob
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import iterative

AGREE = 1e-9
NOTE = "note: OpenBLAS is its serial build here and takes one thread"
THREADED = [os.environ.get("HVI_THREADED_BLAS", ""), *glob.glob("/usr/lib/*/openblas-pthread")]

# Large enough that products of dense blocks are dealt to threads: some thousand unknowns, some hundred of contact.
LARGE = """mesh body = box(2, 1, 1, cells = [{n}, {n}, {n}])
part roof = body.top
part ground = body.bottom
{import_}tensor A = isotropic(young = 5, poisson = 0.3)
tensor B = isotropic(young = 50, poisson = 0.3)
superpotential layer(r) with slope 100*max(r, 0)
{law}space V = vector P1 on body, zero on roof
find u in V for t in [0, 1] by 4 steps from u = [0, 0, 0]{using}
such that for all v in V
    integral(body, A : eps(u') : eps(v)) + integral(body, B : eps(u) : eps(v)) + integral(ground, layer^0(u.nu; v.nu){friction})
    >= integral(body, dot([t, -3*t, 0.5], v))
report
  table u_y = u.y at [1, 0, 0.5], size = norm(u), press = integral(ground, layer.xi)
"""
FRICTION = {"import_": "import friction\n", "law": "superpotential slip(xi) = tresca(xi, bound = 0.3)\n", "friction": " + slip^0(u'.tau; v.tau)"}
PLAIN = dict.fromkeys(FRICTION, "")


def scripts(options):
    for seed in range(options.seed, options.seed + options.scenes):
        yield f"scene{seed}", (iterative.scene, iterative.pair_scene, iterative.several_scene)[seed % 3](seed)
    for using in ("", " using factor = single"):
        yield "large" + using, LARGE.format(n=14, using=using, **PLAIN)
        yield "large, friction" + using, LARGE.format(n=9, using=using, **FRICTION)


def run(program, path, folder, threads, environment):
    answer = folder / "answer.json"
    answer.unlink(missing_ok=True)
    done = subprocess.run([program, "run", path, "--quiet", "--no-files", "--solver", "direct", "--blas-threads", str(threads), "--json", answer], cwd=folder,
                          capture_output=True, text=True, timeout=300, env=environment)
    return done, json.loads(answer.read_text()) if answer.exists() else None


def compare(program, path, folder, environment):
    """What is wrong, or nothing; and a word."""
    one, a = run(program, path, folder, 1, environment)
    if NOTE in one.stderr:
        return "a note for one thread", ""
    word = "no answer"
    for threads in (2, 3):
        several, b = run(program, path, folder, threads, environment)
        again, c = run(program, path, folder, threads, environment)
        serial, same = several.stderr.count(NOTE) == 1, a is not None and a["table"] == b["table"]
        if one.returncode != several.returncode:
            return f"one thread ends with {one.returncode}, {threads} with {several.returncode}: {several.stderr[-400:]}", ""
        if one.returncode != 0:
            continue
        if not b["certificate"]["certified"] or b["table"] != c["table"]:
            return f"{threads} threads: not certified, or other bits in a second run", ""
        difference, column = iterative.apart(a, b)
        if difference > AGREE or serial and not same:
            return f"{column} apart by {difference:.1e} with {threads} threads", ""
        word = "the same bits" if same else f"apart {difference:.1e}"
    return None, word


def judged(program, options, environment):
    wrong, words = 0, []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for name, text in scripts(options):
            path = folder / "scene.hvi"
            path.write_text(text)
            found, word = compare(program, path, folder, environment)
            wrong += found is not None
            words.append(word)
            print(f"{'FAILS' if found else 'ok   '} {name}: {found or word}", flush=True)
    return wrong, words


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=9)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    wrong, words = judged(program, options, {**os.environ})
    for folder in filter(os.path.isdir, THREADED):
        print(f"with the OpenBLAS of {folder}")
        more, threaded = judged(program, options, {**os.environ, "LD_LIBRARY_PATH": folder})
        wrong += more + (not any(word.startswith("apart") for word in threaded))  # else no product took threads
        words += threaded
    sys.exit(wrong > 0 or all(word == "no answer" for word in words))


if __name__ == "__main__":
    main()
