"""The fields of a body in pieces: random scenes by several processes against one process, and files that cannot be written or are gone.

usage: ranks_files.py HVI_RUN [--scenes N] [--seed S] [--ranks N,M] [--only NAME]

Every process writes the cells of its piece. Together the pieces that a PVTU names have every cell of the VTU of one process once, with
values that agree to 1e-9 of the largest; the collection (PVD) names the PVTU, and `files` of the JSON what is there. Then a run that is
stopped and resumed by other numbers of processes, with a piece missing and with all of them; and a piece that cannot be written. Without
the module of PETSc or mpirun the test is skipped (exit code 77).
"""
import argparse
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as xml

import meshio
import numpy

import iterative
import ranks

AGREE = 1e-9
SHOWN = "  fields u, sigma, layer.xi every 3 steps\n"


def script_of(seed):
    text = (iterative.scene, iterative.pair_scene)[seed % 2](seed)
    return text + (SHOWN if " by " in text else SHOWN.replace(" every 3 steps", ""))


def run(program, path, folder, processes, *arguments):
    """A run that writes files, and what its JSON says."""
    out = folder / f"out{processes}"
    answer = folder / f"{processes}.json"
    answer.unlink(missing_ok=True)
    done = subprocess.run([*iterative.launcher(processes), program, "run", path, "--quiet", "-o", out, "--json", answer,
                                 *(arguments if "--solver" in arguments else ("--solver", "iterative", *arguments))], cwd=folder, capture_output=True, text=True, timeout=300)
    if iterative.NO_MODULE in done.stderr:
        print("skipped: " + iterative.NO_MODULE)
        sys.exit(iterative.SKIPPED)
    return done, out, json.loads(answer.read_text()) if answer.exists() else None


def cells(path):
    """By name, a row for each cell: the places of its nodes, their values, and its own values."""
    mesh = meshio.read(path)
    block, = mesh.cells
    rows = {"places": mesh.points[block.data].reshape(len(block.data), -1)}
    for name, values in mesh.point_data.items():
        rows[name] = values.reshape(len(mesh.points), -1)[block.data].reshape(len(block.data), -1)
    for name, (values,) in mesh.cell_data.items():
        rows[name] = values.reshape(len(block.data), -1)
    return rows


def sources(path):
    """The pieces that a PVTU names, and its arrays."""
    grid = xml.parse(path).getroot().find("PUnstructuredGrid")
    arrays = {(array.get("Name"), array.get("NumberOfComponents", "1")) for kind in ("PPointData", "PCellData") for array in grid.find(kind)}
    return [path.parent / piece.get("Source") for piece in grid.findall("Piece")], arrays


def arrays_of(path):
    piece = xml.fromstring(path.read_text()).find("UnstructuredGrid/Piece")
    return {(array.get("Name"), array.get("NumberOfComponents", "1")) for kind in ("PointData", "CellData") for array in piece.find(kind)}


def collection(out):
    found, = out.glob("*.pvd")
    return [(entry.get("timestep"), entry.get("part"), entry.get("file")) for entry in xml.parse(found).getroot().iter("DataSet")]


def apart(whole, pieces, sizes):
    """What is wrong with the pieces of a grid, or nothing."""
    one, several = cells(whole), [cells(piece) for piece in pieces]
    together = {name: numpy.concatenate([piece[name] for piece in several]) for name in one}
    if together["places"].shape != one["places"].shape:
        return f"{len(together['places'])} cells of {len(one['places'])}"
    order = [numpy.lexsort(rows["places"].T) for rows in (one, together)]
    for name in one:
        difference = numpy.abs(one[name][order[0]] - together[name][order[1]]).max(initial=0.0)
        if difference > (0.0 if name == "places" else AGREE * sizes[name]):
            return f"{name} apart by {difference:.1e}"
    return None


def sizes_of(paths):
    out = {}
    for path in paths:
        for name, rows in cells(path).items():
            out[name] = max(out.get(name, 0.0), numpy.abs(rows).max(initial=0.0))
    return out


def wrong_files(out1, outn, n, answer):
    """What is wrong with the files of n processes, or nothing."""
    expected = [(t, part, file.replace(".vtu", ".pvtu") if part == "0" else file) for t, part, file in collection(out1)]
    if collection(outn) != expected:
        return "the collection is another one"
    there = {str(path.relative_to(outn)) for path in outn.iterdir() if not path.name.startswith(".")}
    if set(answer["files"]) != there:
        return f"files {sorted(set(answer['files']) ^ there)}"
    bodies = [out1 / file for _, part, file in collection(out1) if part == "0"]
    sizes = sizes_of(bodies)
    for body in bodies:
        pieces, arrays = sources(outn / body.with_suffix(".pvtu").name)
        if len(pieces) != n or any(arrays_of(piece) != arrays for piece in pieces):
            return "the pieces have other arrays"
        counts = [len(cells(piece)["places"]) if arrays_of(piece) else 0 for piece in pieces]
        if sum(counts) >= 40 * n and max(counts) > 1.3 * min(counts) + 2:
            return f"pieces of {counts} cells"
        if found := apart(body, pieces, sizes):
            return found
    return None


def compare(program, path, folder, options):
    done, out1, _ = run(program, path, folder, 1)
    for n in options.ranks:
        several, outn, answer = run(program, path, folder, n)
        if several.returncode != done.returncode:
            return f"one process ends with {done.returncode}, {n} with {several.returncode}: {several.stderr[-600:]}", ""
        if done.returncode != 0:
            return (None if done.returncode == 3 else done.stderr[-600:]), "no answer"
        if found := wrong_files(out1, outn, n, answer):
            return f"{n} processes: {found}", ""
    return None, f"{len(list(outn.glob('*.pvtu')))} fields"


def scenes(program, options):
    wrong = answers = 0
    for seed in range(options.seed, options.seed + options.scenes):
        if options.only and options.only != f"scene{seed}":
            continue
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            path = folder / "scene.hvi"
            path.write_text(script_of(seed))
            found, word = compare(program, path, folder, options)
        wrong += found is not None
        answers += "fields" in word
        print(f"{'FAILS' if found else 'ok   '} scene{seed}: {found or word}", flush=True)
    print(f"{answers} scenes compared, {wrong} wrong")
    return wrong > 0 or answers == 0


STEPS, FIELDS = 1500, 150
# The matrices of its two forms are multiples of each other, though they are not written so: on two parts with the same cells.
LONG = (ranks.LONG.format(n=12, steps=STEPS) + "  fields u every 10 steps\n").replace("integral(body, B", "integral(all, B").replace(
    "part ground", "part all = body where y > -1\npart ground")


def interrupted(program, path, folder):
    """A run by three processes that was stopped after some of its fields; its exit code."""
    out = folder / "out3"
    stopped = subprocess.Popen([*iterative.launcher(3), program, "run", path, "--quiet", "-o", out, "--solver", "iterative", "--checkpoint", "10"],
                                     cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + ranks.SOON
    while len(list(out.glob("*.pvtu"))) < 3 and time.monotonic() < end and stopped.poll() is None:
        time.sleep(0.01)
    for child in ranks.children(stopped.pid):
        if ranks.rank_of(child) == 0:
            os.kill(child, signal.SIGINT)
    stopped.communicate(timeout=ranks.SOON)
    return stopped.returncode, out


def resumed(program, judge):
    """By another number of processes, with a piece that is gone and with all of them."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        path = folder / "case.hvi"
        path.write_text(LONG)
        code, stopped = interrupted(program, path, folder)
        written = len(list(stopped.glob("*.pvtu")))
        judge(code == 130 and 3 <= written < FIELDS, f"stopped after {written} fields of {FIELDS}: exit code {code}")
        for n in (1, 2):
            shutil.rmtree(folder / f"out{n}", ignore_errors=True)
            shutil.copytree(stopped, folder / f"out{n}")
        lost = stopped / "case_00010_1.vtu"
        lost.unlink()
        done, _, _ = run(program, path, folder, 3, "--resume", "--checkpoint", "10")
        judge(done.returncode == 1 and "case_00010_1.vtu`, which is gone" in done.stderr, f"a piece is gone: exit code {done.returncode}")
        tables = []
        for n in (1, 2):
            done, out, answer = run(program, path, folder, n, "--resume", "--checkpoint", "10")
            judge(done.returncode == 0 and answer["certificate"]["certified"], f"resumed by {n}: exit code {done.returncode}")
            files = [file for _, _, file in collection(out)]
            endings = [".pvtu"] * written + [".vtu" if n == 1 else ".pvtu"] * (FIELDS - written)
            judge([pathlib.Path(file).suffix for file in files] == endings, f"resumed by {n}: {len(files)} files in the collection")
            judge(all((out / file).exists() for file in files), f"resumed by {n}: all of them are there")
            tables.append(answer)
        judge(iterative.apart(*tables)[0] <= AGREE, "resumed by 1 and by 2: the same table")


def refused(program, judge):
    """A folder in the way of a piece: told once, the run goes on, and its exit code is 3."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        path = folder / "case.hvi"
        path.write_text(LONG.replace(f"by {STEPS} steps", "by 30 steps"))
        for process in (0, 1):
            out = folder / "out2"
            shutil.rmtree(out, ignore_errors=True)
            (out / f"case_00010_{process}.vtu").mkdir(parents=True)
            done, _, answer = run(program, path, folder, 2)
            words = f"cannot write `{out}/case_00010_{process}.vtu`: a folder of this name is in the way"
            told = [line for line in done.stderr.splitlines() if words in line]  # at once, and why the exit code is 3
            judge(done.returncode == 3 and len(told) == 2 and "E0702" in told[1], f"a folder in the way of process {process}: exit code {done.returncode}")
            judge(answer is not None and len(answer["table"]["u_y"]) == 30, "the table is whole")
            judge([file for _, _, file in collection(out)] == ["case_00020.pvtu", "case_00030.pvtu"], "the other fields are there")


def without_iterations(program, judge):
    """A run that does not iterate is the first process's alone, and so are its files."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        path = folder / "case.hvi"
        path.write_text(LONG.replace(f"by {STEPS} steps", "by 30 steps"))
        done = [run(program, path, folder, n, "--solver", "direct") for n in (1, 2)]
        names = [{file.name: file.read_bytes() for file in out.iterdir() if file.suffix in (".vtu", ".pvtu", ".pvd")} for _, out, _ in done]
        judge(names[0] == names[1] and len(names[0]) == 4, "the direct solver: the same files with two processes as with one")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--scenes", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ranks", type=lambda text: [int(n) for n in text.split(",")], default=[2, 3])
    parser.add_argument("--only")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    wrong = []

    def judge(good, words):
        print(f"{'ok   ' if good else 'FAILS'} {words}", flush=True)
        if not good:
            wrong.append(words)

    failed = scenes(program, options)
    if not options.only:
        resumed(program, judge)
        refused(program, judge)
        without_iterations(program, judge)
    sys.exit(failed or bool(wrong))


if __name__ == "__main__":
    main()
