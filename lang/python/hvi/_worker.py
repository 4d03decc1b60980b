"""A process of a sweep: reads runs from the standard input and writes what they gave to the standard output, both pickled.

Not the module multiprocessing: that runs the calling script once more in every process, unless it is written for it.
"""
from __future__ import annotations

import pickle
import signal
import sys
from typing import Any


def main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that asked, which ends this one
    incoming, outgoing = sys.stdin.buffer, sys.stdout.buffer
    while True:
        try:
            model, params, keeps = pickle.load(incoming)
        except EOFError:
            return
        answer: Any
        try:
            result = model.run(**params)
            answer = result if keeps else (result.final, result.certified, result.raw["timing"]["total"])
        except Exception as error:  # noqa: BLE001: told where it was asked for
            answer = error
        pickle.dump(answer, outgoing)
        outgoing.flush()


if __name__ == "__main__":
    main()
