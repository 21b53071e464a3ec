"""The same works in memo, by another interpreter; called by `peers.py`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from peer_arrays import Task, Times
from peer_report import FASTEST, NATURAL, TOLERANCE, Given, Report

HERE = Path(__file__).resolve().parent


def with_memo(
    report: Report, given: Given, policies: Any, interpreter: str, values: Any, ours: Any
) -> None:
    import peer_numpy

    a, _, (weak, strong), _ = given.arrays, *policies
    starts, turns = given.turns
    widths = (1, 10)
    task = Task(len(weak), TOLERANCE, given.length, widths, given.offspring)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        a.save(folder / "arrays.npz")
        (folder / "task.json").write_text(json.dumps(asdict(task)))
        np.savez(
            folder / "given.npz",
            weak=weak,
            strong=strong,
            weak_values=values[0],
            strong_values=values[1],
            starts=starts,
            turns=turns,
            search=given.starts,
        )
        done = subprocess.run(
            [interpreter, str(HERE / "peer_memo.py"), place],
            env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
            capture_output=True,
            text=True,
        )
        if done.returncode:
            report.check(f"memo did not run: {done.stderr.strip().splitlines()[-1]}")
            print(done.stderr[-3000:], file=sys.stderr)
            return
        rows = json.loads((folder / "memo.json").read_text())
        results = dict(np.load(folder / "memo.npz"))
    report.check(f"memo: {rows.pop('versions')}.")
    names = {
        "plan": "planning",
        "one": "beliefs, a script",
        "many": f"beliefs, {len(starts):,} scripts",
    }
    names |= {"search 1": "search, greedy", "search 10": "search, beam of 10"}
    for row, times in rows.items():
        what, _, style = row.rpartition(" ")
        who = NATURAL if style == "natural" else FASTEST
        if what == "sweep":
            report.check(
                f"memo, fastest: one sweep of all problems takes {times['cpu']:.2f} s, and "
                f"finds our values settled to {float(results[row + ' 0']):.1e}."
            )
            continue
        report.add(names[what], who, Times(**times))
        if what == "plan":
            found = (results[f"{row} 0"], results[f"{row} 1"])
            worst = max(peer_numpy.residuals(a, *found))
            assert worst <= 3 * TOLERANCE, worst
            report.check(f"Planning in {who}: residual {worst:.1e}.")
        elif what in ("one", "many"):
            far = np.abs(results[f"{row} 0"] - ours[what]).max()
            report.check(f"{names[what].capitalize()}, {who}: {far:.0e} from ours.")
        else:
            actions = results[f"{row} 1"]
            scores = peer_numpy.scores(a, weak, strong, given.starts, actions)
            report.check(
                f"{names[what].capitalize()}, {who}: the best score is {scores.max():.6f}."
            )
