"""Runs of 1e2 to 1e5 processes, on paper: what an iteration sends is measured with few processes, and extrapolated.

Assumed: every process has as many unknowns as those measured, and memory as fast as theirs; 64 processes to a computer, which
share a network of 25 GB/s; 2 microseconds for a message; a reduction takes log2(P) messages one after the other. A part of a large body
has some 15 neighbours and six faces; the largest part measured, of P = 8, has seven and three. Levels of the multigrid get
smaller as those measured do. Iterations grow by as many for each doubling of P as they do in what is measured.
"""
import math

LATENCY, BANDWIDTH = 2e-6, 25e9 / 64  # seconds; bytes a second
NEIGHBOURS, FACES = 15 / 7, 6 / 3
FIRST_ALONE = 0.08  # of a run of one process: what the first process does alone (a profile of slab3d, n = 32)
PROCESSES = (8, 100, 1_000, 10_000, 100_000)


class Model:
    """`plans`: by number of processes, as the JSON of a run has them; `seconds`: of an iteration of one process."""

    def __init__(self, plans, seconds):
        self.most = max(plans)
        self.seconds = seconds
        sent, iterations = plans[self.most]["communication"], plans[self.most]["iterations"]
        self.messages, self.bytes, self.reductions = (sent[what] / iterations for what in ("messages", "bytes", "reductions"))
        rows = [level["rows"] for level in plans[self.most]["multigrid"]]
        self.levels, self.coarser = len(rows), (rows[0] / rows[-1]) ** (1 / (len(rows) - 1))
        self.growth = (iterations / plans[1]["iterations"] - 1) / math.log2(self.most)

    def iteration(self, processes):
        """Seconds of arithmetic, messages, bytes, reductions."""
        many = processes > self.most
        levels = 1 + max(0.0, math.log(processes / self.most) / math.log(self.coarser)) / self.levels
        messages = self.messages * levels * (NEIGHBOURS if many else 1)
        sent = self.bytes * (FACES if many else 1)  # coarse levels send little
        return self.seconds, messages * LATENCY, sent / BANDWIDTH, self.reductions * math.log2(processes) * LATENCY

    def iterations(self, processes):
        """Times those of one process."""
        return 1 + self.growth * math.log2(processes)

    def speed(self, processes):
        """Times as many unknowns in the same time as one process: now, and where laws and vectors are dealt out, too."""
        shared = sum(self.iteration(processes)) / self.seconds * self.iterations(processes) * (1 - FIRST_ALONE)
        return processes / (shared + FIRST_ALONE * processes), processes / (shared + FIRST_ALONE)


def on_paper(plans, seconds):
    model = Model(plans, seconds)
    print("    what an iteration sends, the process with most:")
    for processes, plan in plans.items():
        if processes > 1:
            sent = plan["communication"]
            print(f"    {processes} processes: {sent['messages'] / plan['iterations']:.0f} messages, {sent['bytes'] / plan['iterations'] / 1e3:.0f} kB, "
                  f"{sent['reductions'] / plan['iterations']:.1f} reductions; levels "
                  + ", ".join(f"{level['rows']:.0f} ({level['entries'] / level['rows']:.0f} a row)" for level in plan["multigrid"]))
    print("    on paper: milliseconds of an iteration (arithmetic, messages, bytes, reductions), iterations over those of one process, speed now and with laws and vectors dealt out")
    for processes in PROCESSES:
        parts = ", ".join(f"{1e3 * part:.2f}" for part in model.iteration(processes))
        now, own = model.speed(processes)
        print(f"    {processes:7d}: {parts}; {model.iterations(processes):.2f}; {now:.1f}, {own:.0f}")
