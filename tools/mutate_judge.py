"""Which tests reach a mutant of tools/mutate, and whether one of them fails with it."""
import collections
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import tempfile
import threading

import mutate_build

LEFT_OUT = "long|processors"  # labels: what the others do not see, these two, which repeat them, do not either
MEMORY = 6 << 30


def execute(command, folder, environment, limit):
    """Runs in a folder of its own for temporary files. (exit code, CPU seconds of it and its children); limit in CPU seconds."""
    def bounds():
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory(prefix="hvi_mutant_") as scratch:
        here = {**os.environ, "TMPDIR": scratch, "TEST_TMPDIR": scratch, **environment}
        child = subprocess.Popen(command, cwd=folder or scratch, env=here, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                 stdin=subprocess.DEVNULL, start_new_session=True, preexec_fn=bounds)
        # Something that sleeps for ever uses no CPU time; on a busy machine time goes by, too.
        alarm = threading.Timer(30 * limit + 120, lambda: os.killpg(child.pid, signal.SIGKILL))
        alarm.start()
        _, status, usage = os.wait4(child.pid, 0)
        alarm.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        return child.returncode, usage.ru_utime + usage.ru_stime


class Court:
    def __init__(self, tree, home, build, asked):
        self.tree, self.home, self.build, self.jobs, self.without = tree, home, build, asked.jobs, asked.without
        self.tests = []

    def listed(self):
        shown = subprocess.run(["ctest", "--show-only=json-v1", "-LE", LEFT_OUT], cwd=self.tree.build_folder, capture_output=True,
                               text=True, check=True).stdout
        for test in json.loads(shown)["tests"]:
            properties = {p["name"]: p["value"] for p in test.get("properties", [])}
            if "command" in test and "DISABLED" not in properties and not (self.without and re.search(self.without, test["name"])):
                folder = properties.get("WORKING_DIRECTORY", "")
                folder = "" if pathlib.Path(folder) == self.tree.build_folder / "tests" else folder
                yield {"name": test["name"], "command": test["command"], "folder": folder}

    def sources_of(self, test):
        """Digest of what the test is made of, the program under test left out."""
        source, total = self.tree.source, hashlib.sha1(json.dumps(test).encode())
        if program := re.search(r"/test_(solver|lang)_(\w+)$", test["command"][0]):
            files = sorted(p for p in (source / "tests" / program.group(1) / program.group(2)).rglob("*") if p.is_file())
        else:
            files = [p for p in map(pathlib.Path, test["command"]) if source in p.parents and p.is_file()
                     and self.tree.build_folder not in p.parents]
        for file in files:
            total.update(file.read_bytes())
        return total.hexdigest()

    def reach(self, test):
        """Runs a test with no mutant on: does it pass, how long, which mutants does it reach?"""
        with tempfile.NamedTemporaryFile(prefix="hvi_reached_") as file:
            file.write(bytes(mutate_build.BYTES))
            file.flush()
            code, seconds = execute(test["command"], test["folder"], {"HVI_MUTANT_REACHED": file.name}, 600)
            hit = pathlib.Path(file.name).read_bytes()
        return {"passes": code == 0, "seconds": seconds, "reached": [i for i, byte in enumerate(hit) if byte]}

    def see_what_tests_reach(self):
        store = self.home / "reached.jsonl"
        known = {}
        if store.exists():
            for line in store.read_text().splitlines():
                entry = json.loads(line)
                known[entry["digest"]] = entry
        lock = threading.Lock()

        def one(test):
            digest = hashlib.sha1((self.build + self.sources_of(test)).encode()).hexdigest()
            if digest not in known:
                entry = {"digest": digest, **self.reach(test)}
                with lock, open(store, "a") as out:
                    out.write(json.dumps(entry) + "\n")
                known[digest] = entry
            return {**test, **known[digest]}

        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            self.tests = list(pool.map(one, self.listed()))
        broken = [t["name"] for t in self.tests if not t["passes"]]
        print(f"{len(self.tests)} tests, {len(broken)} fail without a mutant and are left out: {', '.join(broken[:8])}", flush=True)
        self.tests = [t for t in self.tests if t["passes"]]

    def judge_all(self, sites, most):
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as pool:
            waiting = {pool.submit(self.judge, site, most): site for site in sites}
            for done in concurrent.futures.as_completed(waiting):
                yield waiting[done], done.result()

    def judge(self, site, most):
        number, spent = site.number, 0.0
        covering = [t for t in self.tests if number in t["reached"]]
        for command, folder, seconds, name in groups_of(covering, site.file):
            if spent > most:
                return {"verdict": "survived", "by": f"{most:.0f} s of the tests that reach it", "seconds": spent}
            limit = 5 * seconds + 10
            code, used = execute(command, folder, {"HVI_MUTANT": str(number)}, limit)
            spent += used
            if code != 0:
                endless = " (endless)" if used > limit else ""
                return {"verdict": "killed", "by": name + endless, "seconds": spent}
        return {"verdict": "survived" if covering else "not reached", "by": "", "seconds": spent}


def groups_of(covering, file):
    """(command, folder, seconds, name): the file's own tests first, then by time, those of the language's text last for a fault in
    solver/; cases of one program run in one process."""
    start_up = 0.02
    programs, out = collections.defaultdict(list), []
    for test in covering:
        words = test["command"]
        if len(words) > 1 and words[1].startswith("--gtest_filter="):
            programs[words[0]].append(test)
        else:
            out.append((test["command"], test["folder"], test["seconds"], test["name"]))
    for program, cases in programs.items():
        cases.sort(key=lambda case: case["seconds"])
        for part in (cases[k:k + 150] for k in range(0, len(cases), 150)):
            filters = ":".join(c["command"][1].split("=", 1)[1] for c in part)
            out.append(([program, f"--gtest_filter={filters}", "--gtest_fail_fast"],
                        part[0]["folder"], sum(max(0.001, c["seconds"] - start_up) for c in part), f"{pathlib.Path(program).name}"))
    own = "test_" + "_".join(file.split("/")[:2])
    elsewhere = re.compile(r"lang[:/]|test_lang_" if file.startswith("solver/") else "$^")
    return sorted(out, key=lambda group: (0.1 if group[3] == own else 30 if elsewhere.match(group[3]) else 1) * group[2])
