#!/usr/bin/env python3
"""The state of least energy of bodies on laws that soften, drop and jump up, against all combinations.

    least_energy.py HVI_RUN [--scenes N] [--seed S]

The bodies, laws and loads of branches.py (turned, scaled, long or stiff), those with at most four points
on the ground, run with `branch = least_energy`. The reference: every combination of pieces and breaks of
the laws, one linear solve each, and the energy of the state it gives; the least of them all is the least.

wrong: a state with more energy than the least, by more than the run says is possible; a step that is
said to be proved is held to 1e-7 of the energies involved (printed digits). refused: exit code other than 0.
"""
import argparse, itertools, json, pathlib, re, subprocess, sys, tempfile
import numpy as np
import branches


class Recorder:
    """Takes the place of the reference that follows curves: keeps what it is given."""
    last = None

    def __init__(self, c, w, breaks, pieces):
        self.c, self.w, self.breaks = c, w, breaks
        self.v = np.array([p[0] for p in pieces])
        self.s = np.array([p[1] for p in pieces])
        self.x = np.array([breaks[max(i - 1, 0)] for i in range(len(pieces))])
        self.loads, self.ends = [], []
        Recorder.last = self

    def go(self, to, start, end):
        self.loads.append(to)
        return True

    def z(self):
        return self.loads[-1]

    def potential(self, z):
        """j of each entry, 0 at the first break."""
        out = np.where(z < self.breaks[0], self.s[0] * (z - self.breaks[0]) ** 2 / 2 + self.v[0] * (z - self.breaks[0]), 0.0)
        for i in range(1, len(self.v)):
            high = self.breaks[i] if i < len(self.breaks) else np.inf
            d = np.clip(z, self.x[i], high) - self.x[i]
            out = out + self.v[i] * d + self.s[i] * d * d / 2
        return out

    def energy(self, z, b):
        """Over that of the free body, and the size of its parts; z: a row a state."""
        give = b - z
        body = 0.5 * np.einsum("ij,ij->i", give, np.linalg.solve(self.c, give.T).T)
        law = self.potential(z) * self.w
        return body + law.sum(axis=1), np.abs(body) + np.abs(law).sum(axis=1)

    def least(self, b):
        stiff = np.linalg.inv(self.c)
        n, best = len(b), np.inf
        combinations = np.array(list(itertools.product(range(2 * len(self.breaks) + 1), repeat=n)))
        for part in np.array_split(combinations, max(1, len(combinations) // 20000)):
            i, held = part // 2, part % 2 == 1
            k = np.repeat(stiff[None], len(part), axis=0)
            right = np.repeat((stiff @ b)[None], len(part), axis=0)
            k[:, range(n), range(n)] += self.w * self.s[i]
            right = right - self.w * (self.v[i] - self.s[i] * self.x[i])
            k = np.where(held[:, :, None], np.eye(n)[None], k)
            right = np.where(held, self.breaks[np.minimum(i, len(self.breaks) - 1)], right)
            determinant = np.abs(np.linalg.det(k))
            good = determinant > 1e-12 * np.prod(np.abs(k).max(axis=2), axis=1)
            z = np.linalg.solve(k[good], right[good][:, :, None])[:, :, 0]
            best = min(best, self.energy(z, b)[0].min())
        return best


def judge(hvi, script, reference, dim, up, count):
    text = script.read_text().replace(" by N steps", " by N steps using branch = least_energy")
    script.write_text(text)
    out = script.with_suffix(".json")
    done = subprocess.run([hvi, "run", str(script), "--json", str(out), "--no-files"], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        return None, done.stderr.strip().splitlines()[:1], 0, 0
    data = json.loads(out.read_text())
    gaps = {}
    for step, said in re.findall(r"step (\d+) \(t = [^)]*\): least energy found, not proved: (.*)", done.stdout):
        most = re.search(r"by up to ([-+.e\d]+) of", said)
        gaps[int(step)] = float(most.group(1)) if most else np.inf
    proved, worst = 0, ""
    for step, (t, b) in enumerate(zip(branches.TIMES, reference.loads), 1):
        z = branches.heights(data, t, dim, up, count)
        energy, size = reference.energy(z[None], b)
        more = (energy[0] - reference.least(b)) / size[0]
        proved += step not in gaps
        if more > gaps.get(step, 0.0) * 1.01 + 1e-7:
            worst = f"t = {t}: {more:.1e} of the energies more than the least, said {gaps.get(step, 'proved')}"
    return worst == "", [worst], proved, len(reference.loads)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("hvi")
    parser.add_argument("--scenes", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    branches.Curve = Recorder
    certified = wrong = refused = proved = steps = scenes = number = 0
    with tempfile.TemporaryDirectory() as name:
        folder = options.keep or pathlib.Path(name)
        folder.mkdir(exist_ok=True)
        while scenes < options.scenes:
            number += 1
            rng = np.random.default_rng([options.seed, number])
            script, dim, up, count, _, _, _ = branches.scene(rng, folder, number)
            reference = Recorder.last
            if count > 4 or (2 * len(reference.breaks) + 1) ** count > 40000:
                continue
            scenes += 1
            good, said, p, s = judge(options.hvi, script, reference, dim, up, count)
            proved, steps = proved + p, steps + s
            certified += good is not None
            refused += good is None
            wrong += good is False
            if not good:
                print(f"scene {number} ({dim}D, {count} points): {'refused' if good is None else 'wrong'}: {said}", flush=True)
    print(f"least energy proved in {proved} of {steps} steps")
    print(f"family least_energy: scenes {scenes}, certified {certified}, wrong {wrong}, refused {refused}")
    return 1 if wrong or refused or not proved else 0


if __name__ == "__main__":
    sys.exit(main())
