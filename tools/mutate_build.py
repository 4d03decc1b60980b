"""The copy of the project that holds the mutants of tools/mutate: drawn, written into its sources, built.

The copy lies so that paths relative to the build folder are those of build/release: with ccache nothing
but what was mutated is compiled.
"""
import collections
import dataclasses
import hashlib
import json
import os
import pathlib
import random
import re
import subprocess
import sys

import mutate_named
import mutate_sites as sites

ROOT = pathlib.Path(__file__).resolve().parent.parent
HOME = ROOT / "build" / "mutate"
TESTS = re.compile(r"(tests|examples|docs|stdlib)/")
MUTATED = re.compile(r"(solver|lang/check)/(?!mesh/gmsh/)")  # that one is a library of its own, opened at run time
MOST_INCLUDED = 4  # a header that more files include is left out: all of them would be compiled
BYTES = 4096
HEADER = """#pragma once
#include <cstdlib>
#include <fcntl.h>
#include <sys/mman.h>
namespace hvi_mutant {
inline unsigned char nobody[%(bytes)d];
inline int active = -1;
inline unsigned char* reached = nobody;
inline bool start() {
  if (const char* number = std::getenv("HVI_MUTANT")) active = std::atoi(number);
  const char* file = std::getenv("HVI_MUTANT_REACHED");
  if (file == nullptr) return true;
  const int descriptor = open(file, O_RDWR);
  void* shared = mmap(nullptr, %(bytes)d, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (shared != MAP_FAILED) reached = static_cast<unsigned char*>(shared);
  return true;
}
inline const bool started = start(); // before any other variable of a file with mutants
inline bool on(int number) {
  reached[number] = 1;
  return active == number;
}
} // namespace hvi_mutant
""" % {"bytes": BYTES}


class Tree:
    def __init__(self, home):
        self.source = home / "src"
        self.build_folder = self.source / "build" / "release"
        self.stamp = home / "sources.sha1"

    def names(self):
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
        return [n for n in listed if n and (ROOT / n).is_file()]

    def digest(self):
        total = hashlib.sha1()
        for name in self.names():
            if re.match(r"solver/|lang/", name):
                total.update(name.encode() + b"\0" + (ROOT / name).read_bytes())
        return total.hexdigest()

    def same_sources(self):
        return self.stamp.exists() and self.stamp.read_text() == self.digest()

    def copy(self, only_tests):
        """Only what changed is written, so that the next build is short."""
        for name in self.names():
            if not only_tests or TESTS.match(name):
                put(self.source / name, (ROOT / name).read_bytes(), (ROOT / name).stat().st_mode)
        if not only_tests:
            put(self.source / "hvi_mutant.hpp", HEADER.encode())
            self.stamp.write_text(self.digest())

    def configure(self, several_at_once=True):
        """Sources without mutants are compiled eight at once; the list of commands has a line for each only without that."""
        unity = ["-DCMAKE_UNITY_BUILD=" + ("ON" if several_at_once else "OFF"), "-DCMAKE_UNITY_BUILD_BATCH_SIZE=8"]
        done = subprocess.run(["cmake", "-S", self.source, "-B", self.build_folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                               "-DHVI_BENCH=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", *unity], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(done.stdout + done.stderr)

    def commands(self):
        return {entry["file"]: entry for entry in json.loads((self.build_folder / "compile_commands.json").read_text())}

    def ninja(self, *more):
        return subprocess.run(["ninja", "-C", self.build_folder, "-j", str(os.cpu_count()), *more], capture_output=True, text=True)

    def build(self):
        done = self.ninja()
        if done.returncode != 0:
            sys.exit(done.stdout[-3000:] + "\nthe build with the mutants failed")


def put(path, content, mode=0o644):
    if path.exists() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    path.chmod(mode)


def save(path, chosen):
    path.write_text(json.dumps([dataclasses.asdict(s) for s in chosen], indent=1))


def load(path):
    return [sites.Site(**entry) for entry in json.loads(path.read_text())]


def users_of_headers(source):
    """By header, as it is included: the .cpp files that read it, through other headers, too."""
    includes = {}
    for path in (p for folder in ("solver", "lang", "tests", "bench") for p in (source / folder).rglob("*.[ch]pp")):
        includes[str(path.relative_to(source))] = re.findall(r'^#include "(.+?)"', path.read_text(), re.M)
    users = collections.defaultdict(set)
    for file in includes:
        seen, todo = set(), [file] if file.endswith(".cpp") else []
        while todo:
            new = [name for name in includes.get(todo.pop(), []) if name not in seen]
            seen.update(new)
            todo += new
        for header in seen:
            users[header].add(str(source / file))
    return users


def files_to_mutate(tree):
    """(file, compile command) of sources and of headers that few files include."""
    commands, users, out = tree.commands(), users_of_headers(tree.source), []
    for name in sorted(str(p.relative_to(tree.source)) for folder in ("solver", "lang/check")
                       for p in (tree.source / folder).rglob("*.[ch]pp")):
        path = str(tree.source / name)
        if not MUTATED.match(name) or sites.PRINTING.match(name):
            continue
        compiled = [path] if path in commands else sorted(users[name] & commands.keys())
        if 0 < len(compiled) <= MOST_INCLUDED:
            out.append((path, commands[compiled[0]]))
    return out


def sites_of(tree, file, command):
    """Reading a file takes seconds: what was found is kept for as long as the file is the same."""
    kept = HOME / "sites" / hashlib.sha1((str(tree.source) + file).encode() + pathlib.Path(file).read_bytes()).hexdigest()
    if not kept.exists():
        kept.parent.mkdir(exist_ok=True)
        save(kept, sites.Finder(file, tree.source, sites.arguments_of(command)).sites)
    return load(kept)


def draw(tree, count, seed, wanted):
    """In two stages: a third as many files, by their length; then for each mutant a file of those, a kind and a site of it."""
    dice = random.Random(seed)
    files = [(f, c) for f, c in files_to_mutate(tree) if re.search(wanted, f)]
    lengths = {f: len(pathlib.Path(f).read_text().splitlines()) for f, _ in files}
    drawn = dice.choices(files, [lengths[f] for f, _ in files], k=(count + 2) // 3)
    chosen = []
    for _ in range(20 * count):
        if len(chosen) == count:
            break
        file, command = dice.choice(drawn)
        kinds = collections.defaultdict(list)  # a kind first: numbers would be most of all
        for site in sites_of(tree, file, command):
            kinds[site.kind].append(site)
        if not kinds:
            continue
        site = dice.choice(kinds[dice.choice(sorted(kinds))])
        if not any(site.file == other.file and sites.overlap(site, other) for other in chosen):
            chosen.append(site)
    return chosen


def named_sites(tree):
    out = []
    for name, file, before, after, form in mutate_named.NAMED:
        text = (tree.source / file).read_text()
        if text.count(before) != 1:
            sys.exit(f"tools/mutate_named.py, {name}: `{before}` stands {text.count(before)} times in {file}")
        start = len(text[:text.index(before)].encode())
        out.append(sites.Site(file, text[:text.index(before)].count("\n") + 1, start, start + len(before.encode()), name, before,
                              after, form))
    return out


def compile_mutants(tree, chosen):
    """Writes the mutants and compiles; those that do not compile are left out."""
    for number, site in enumerate(chosen):
        site.number = number
    clean = {s.file: (tree.source / s.file).read_bytes() for s in chosen}
    # With -O1 and no warnings they compile in half of the time.
    cpp = " ".join(sorted(f"${{CMAKE_SOURCE_DIR}}/{f}" for f in clean if f.endswith(".cpp")))
    top = tree.source / "CMakeLists.txt"
    put(top, (ROOT / "CMakeLists.txt").read_bytes() + f"\nset_source_files_properties({cpp} DIRECTORY solver lang PROPERTIES "
        f"COMPILE_OPTIONS \"-O1;-w\" SKIP_UNITY_BUILD_INCLUSION ON)\n".encode())
    tree.configure()
    alive = list(chosen)
    while True:
        for file, text in clean.items():
            here = [s for s in alive if s.file == file]
            put(tree.source / file, sites.rewrite(text, here) if here else text)
        done = tree.ninja("-k", "0")
        wrong = to_drop(done.stdout, alive)
        if done.returncode == 0 or not wrong:
            return alive
        print(f"{len(wrong)} do not compile", file=sys.stderr)
        alive = [s for s in alive if s not in wrong]


def to_drop(output, alive):
    """Mutants at the lines where the compiler complains; else constants of those files, else all of their mutants."""
    errors = collections.defaultdict(set)
    for match in re.finditer(r"^(?:In file included from )?(\S+?):(\d+)[:,].*?(error|$)", output, re.M):
        if match.group(3) == "error":
            errors[match.group(1)].add(int(match.group(2)))
    wrong = []
    for path, lines in errors.items():
        here = [s for s in alive if path.endswith("/" + s.file)]
        at_line = [s for s in here if any(s.line <= line <= s.line + s.before.count("\n") for line in lines)]
        wrong += at_line or [s for s in here if s.form == "constant"] or here
    return wrong
