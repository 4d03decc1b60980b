"""Rows of tools/bench people: the size of reports of large bodies, and how long a browser takes until one can be looked at."""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "lang" / "report"))
import devtools  # noqa: E402

SCENE = """mesh body = {mesh}
part top = body.top
part bottom = body.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
superpotential layer(r) = 50*pos(r)^2
space V = vector P1 on body, zero on top
find u in V such that for all v in V
    integral(body, B : eps(u) : eps(v)) + integral(bottom, layer^0(u.nu; v.nu)) >= integral(body, dot({load}, v))
report
  table a = largest(body, u.y)
  fields u
"""
BODIES = {"in the plane, 200,000 cells": ("rectangle(2, 1, cells = [400, 250])", "[0, -1]"),
          "in space, 196,608 cells": ("box(1, 1, 1, cells = [32, 32, 32])", "[0, -1, 0]")}
RUNS = 3
SECONDS = 3, 1  # must, aim


def seconds_to_open(page, folder, run):
    """From the address to fields that can be turned, by the clock of the page."""
    browser = devtools.Browser(devtools.chromium(), folder / f"profile{run}")
    try:
        browser("Page.navigate", url=page.as_uri())
        browser.wait("document.body && document.body.dataset.ready === 'yes'")
        assert not browser.errors, browser.errors
        return browser.run("document.body.dataset.readyAt / 1000")
    finally:
        browser.close()


def reports(quick, row, program):
    rows = []
    if devtools.chromium() is None:
        print("there is no Chromium: the time to open a report is left out (Debian: chromium)")
    for name, (mesh, load) in list(BODIES.items())[:1 if quick else None]:
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            (folder / "scene.hvi").write_text(SCENE.format(mesh=mesh, load=load))
            subprocess.run([program, "report", "scene.hvi", "-o", "out", "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            page = folder / "out" / "scene_report.html"
            row(rows, f"report of a body {name}: size", page.stat().st_size / 1e6, "-", "-", "MB", None)
            if devtools.chromium() is None:
                continue
            seconds = sorted(seconds_to_open(page, folder, run) for run in range(RUNS))[RUNS // 2]
            row(rows, f"report of a body {name}: opened by Chromium", seconds, *SECONDS, "s", seconds <= SECONDS[0])
    return rows
