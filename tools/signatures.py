"""Dimensions of functions and laws, as `hvi-run dump --units` infers them: for tools/stdlib_docs and tools/function_docs."""
import pathlib
import subprocess
import tempfile

SCENE = """units SI
{declarations}
mesh body = rectangle(1 [m], 1 [m], cells = [2, 2])
part wall = body.left
part right = body.right
kernel C(lag) = exp(-lag/(1 [s]))*isotropic(lambda = 1 [Pa/s], mu = 1 [Pa/s])
space V = vector P1 on body, zero on wall
find u in V for t in [0, 1] [s] by 1 steps from u = 0 such that for all v in V
  integral(body, 1 [Pa]*(eps(u) : eps(v))) + integral(body, history(C, eps(u)) : eps(v)) >= integral(body, dot([0, 1 [N/m^3]], v))
"""


def signatures(program, declarations):
    """name: "name(a [a], b [a]) [1]" of what these lines declare and import."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "scene.hvi").write_text(SCENE.format(declarations=declarations))
        done = subprocess.run([program, "dump", "--units", "scene.hvi"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {line.split("(")[0]: line for line in done.stdout.splitlines()}
