"""What a profile says of the kernels of BLAS, with those that OpenBLAS is told to take.

usage: kernels.py HVI_RUN

OpenBLAS heeds OPENBLAS_CORETYPE on x86 processors; the advice appears where the processor has AVX-512 (by the kernel's list
of what it has) and the kernels do not use it.
"""
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

SCRIPT = """mesh rod = rectangle(1, 1, cells = [2, 2])
part end = rod.left
tensor A = isotropic(young = 1, poisson = 0.3)
space V = vector P1 on rod, zero on end
find u in V for t in [0, 1] by 2 steps from u = [0, 0]
such that for all v in V
  integral(rod, A : eps(u') : eps(v)) >= integral(rod, dot([t, 0], v))
report
  table size = norm(u)
"""
ADVICE = "OPENBLAS_CORETYPE=SkylakeX"
NEEDED = {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}


def profile(program, folder, kernels):
    done = subprocess.run([program, "run", "rod.hvi", "--no-files", "--profile"], cwd=folder, capture_output=True, text=True, timeout=60,
                          env=dict(os.environ, OPENBLAS_CORETYPE=kernels))
    named = re.search(r"^BLAS: OpenBLAS with its kernels for (\w+)$", done.stderr, re.MULTILINE)
    return done.returncode, named.group(1) if named else "", done.stderr.count(ADVICE)


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    listed = pathlib.Path("/proc/cpuinfo").read_text().split() if platform.machine() == "x86_64" else []
    wide = NEEDED <= set(listed)
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "rod.hvi").write_text(SCRIPT)
        for kernels in ("Haswell", "Zen", "Sandybridge", "SkylakeX") if wide else ("Haswell", "Sandybridge"):
            status, named, advice = profile(program, folder, kernels)
            taken = kernels if platform.machine() == "x86_64" else named
            expected = int(wide and taken in ("Haswell", "Zen"))
            print(f"{kernels}: named {named}, advice {advice} times")
            if status != 0 or named == "" or named.lower() != taken.lower() or advice != expected:
                wrong.append(kernels)
    print("wrong: " + ", ".join(wrong) if wrong else "all as expected")
    return 1 if wrong else 0


sys.exit(main())
