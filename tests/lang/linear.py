"""Long scripts take time in proportion to their length, and limits are told as what they are.
usage: linear.py HVI_RUN messages | times        `times` compares CPU seconds of a length with those of four times as much"""
import pathlib
import resource
import subprocess
import sys
import tempfile

HEAD = """mesh slab = rectangle(2, 1, cells = [4, 2])
part roof = {roof}
part ground = slab.bottom
tensor B = isotropic(young = 70, poisson = 0.3)
{more}
space V = vector P1 on slab, zero on roof
find u in V
such that for all v in V
    integral(slab, B : eps(u) : eps(v)) {law}
 >= integral(slab, dot([0, {load}], v))
report
  table a = u.y at [1, 0]
"""


def script(more="", roof="slab.top", law="", load="-1"):
    text = HEAD.format(more=more, roof=roof, law=law, load=load)
    return text if law else text.replace(">=", " =")


def law(n):
    return script(more="superpotential s(r) with slope" + "".join(f" | r < {i} -> {i}*r" for i in range(1, n)) + " | otherwise -> 0",
                  law="+ integral(ground, s^0(u.nu; v.nu))")


def chain(n):
    return script(more="fn f0(x) = x\n" + "".join(f"fn f{i}(x) = f{i - 1}(x)\n" for i in range(1, n)), load=f"-f{n - 1}(1)")


def doubled(n):
    return script(more="part p0 = slab.top\n" + "".join(f"part p{i} = p{i - 1} + p{i - 1}\n" for i in range(1, n)))


KINDS = {
    "unknown names": lambda n: script(more="".join(f"param known{i} = {i}\nparam p{i} = unknown{i}\n" for i in range(n))),
    "one unknown name": lambda n: script(more="".join(f"param known{i} = {i}\nparam p{i} = unknown\n" for i in range(n))),
    "sums of places": lambda n: script(roof="slab.top" + " + slab.top - slab.top" * n),
    "cases of a function": lambda n: script(more="fn f(r) =" + "".join(f" | r < {i} -> {i}" for i in range(n)) + " | otherwise -> 0", load="-f(x)"),
    "cases of a law": law,
    "functions": lambda n: script(more="".join(f"fn f{i}(x) = x + {i}\n" for i in range(n))),
    "columns": lambda n: script() + "".join(f"  table b{i} = {i}*u.y at [1, 0]\n" for i in range(n)),
    "brackets": lambda n: script(load="(" * n + "1" + ")" * n),
    "operations": lambda n: script(load="1" + " - 1" * n),
    "parts": lambda n: script(more="".join(f"part p{i} = slab.left\n" for i in range(n))),
    "comments": lambda n: script(more="# nothing\n" * n),
}
SIZES = {"cases of a law": 8000, "columns": 1000, "comments": 40000, "functions": 8000, "parts": 4000, "sums of places": 12000}


def go(program, text, *words):
    """Exit code, messages, CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "long.hvi"
        path.write_text(text)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([program, "check", "--script-only", path, *words], capture_output=True, text=True, timeout=600)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode, done.stderr, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def messages(program):
    wrong = []

    def expect(what, text, exit_, word, without="nothing of this"):
        code, said, _ = go(program, text)
        if code != exit_ or word not in said or without in said:
            wrong.append(f"{what}: exit code {code}\n{said[:400]}")

    expect("100 functions that call one another", chain(100), 0, "")
    expect("101 of them", chain(101), 1, "E0216", without="calls itself")
    expect("1000 of them", chain(1000), 1, "levels deep", without="calls itself")
    expect("a function that calls itself", script(more="fn f(x) = f(x) + 1\n", load="-f(1)"), 1, "calls itself")
    expect("two that call each other", script(more="fn f(x) = g(x)\nfn g(x) = f(x)\n", load="-f(1)"), 1, "calls itself")
    expect("f(f(...)) 200 deep is no recursion", script(more="fn f(x) = x\n", load="-" + "f(" * 200 + "1" + ")" * 200), 0, "")
    expect("1200 places", script(roof="slab.top" + " + slab.top" * 1199), 0, "")
    expect("1201 places", script(roof="slab.top" + " + slab.top" * 1200), 1, "E0216")
    expect("a part that doubles 60 times", doubled(60), 1, "E0216")
    expect("256 cases of a law", law(257), 0, "")
    expect("257 of them", law(258), 1, "E0216")
    code, said, _ = go(program, KINDS["unknown names"](3000))
    if code != 1 or "did you mean `known0`?" not in said:
        wrong.append(f"the first unknown names have suggestions: {said[:300]}")
    print("\n".join(wrong) or "messages: as they should be")
    return bool(wrong)


def times(program):
    """Four times the length: four times the work, sixteen times when it grows with the square. In between lies the bound."""
    wrong = 0
    for kind, make in KINDS.items():
        n = SIZES.get(kind, 6000)
        _, _, empty = go(program, script())
        one = min(go(program, make(n))[2] for _ in range(3)) - empty
        four = min(go(program, make(4 * n))[2] for _ in range(3)) - empty
        ratio = four / max(one, 0.02)
        print(f"{kind:24} {n:6} {one:8.3f} s   {4 * n:6} {four:8.3f} s   {ratio:5.1f}")
        wrong += ratio > 9
    return wrong > 0


sys.exit({"messages": messages, "times": times}[sys.argv[2]](sys.argv[1]))
