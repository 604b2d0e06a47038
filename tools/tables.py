"""Count methods over all test frames and store the counts where the chapters find them.

    python tools/tables.py [--protocol released|full] [--noise SIGMA] [--again] [METHOD...]

Without names: every method and reference. Only what the stored counts lack is counted, methods that
are new or have other weights, unless ``--again`` is given. The file is written after each method.
"""

import argparse
import hashlib
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parents[1] / "book" / "results"


def main(arguments: Sequence[str] | None = None) -> int:
    """Count and store; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("methods", nargs="*", metavar="METHOD")
    parser.add_argument("--protocol", default="released", choices=("released", "full"))
    parser.add_argument("--noise", type=float, default=1200.0, help="Gaussian sigma, counts")
    parser.add_argument("--again", action="store_true", help="count these methods again")
    given = parser.parse_args(arguments)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # before NumPy and torch are loaded
    from cmtof.methods import METHODS, find_method, names_of
    from cmtof.scenes.frame import held_out_frames

    names = given.methods or [
        *names_of("all", given.protocol),
        *(name for name, method in METHODS.items() if method.kind == "reference"),
    ]
    path = RESULTS / f"table2_{given.protocol}_{given.noise:g}.json"
    settings = {"protocol": given.protocol, "noise": given.noise, "seed": 0}
    held: dict[str, Any] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    if held.get("settings") != settings:
        command = f"python tools/tables.py --protocol {given.protocol} --noise {given.noise:g}"
        held = {"command": command, "settings": settings, "weights": {}, "frames": []}
    frames = held_out_frames()
    for name in (find_method(name).name for name in names):
        weights = weights_of(name, given.protocol)
        counted = held["frames"] and name in held["frames"][0]["methods"]
        if counted and held["weights"].get(name, "") == weights and not given.again:
            continue
        add(held, name, frames)
        if weights:
            held["weights"][name] = weights
        write(held, path)
    return 0


def weights_of(name: str, protocol: str) -> str:
    """SHA-256 of the shipped weights of a method; empty without any."""
    from cmtof.network.weights import weights_path

    path = weights_path(name, protocol)
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def add(held: dict[str, Any], name: str, frames: Sequence[Any]) -> None:
    """Count a method over all frames and join its counts with those of the others."""
    from cmtof.evaluation import Evaluation

    evaluation = Evaluation([name], **held["settings"]).add_all(frames)
    counts = evaluation.counts()
    old = held["frames"] or [{"methods": {}} for _ in counts]
    held["frames"] = [
        new | {"methods": before["methods"] | new["methods"]}
        for before, new in zip(old, counts, strict=True)
    ]
    scores = evaluation.report()["methods"][name]
    print(name, {key: round(rate, 4) for key, rate in scores.items()}, flush=True)


def write(held: dict[str, Any], path: Path) -> None:
    """Store counts, one frame a line, with their hash."""
    from cmtof import __version__
    from cmtof.evaluation import digest
    from cmtof.files import written_whole

    frames = ",\n".join(json.dumps(frame) for frame in held["frames"])
    head = {key: held[key] for key in ("command", "settings", "weights")}
    head |= {"version": __version__, "sha256": digest(held["frames"])}
    with written_whole(path) as part:
        part.write_text(json.dumps(head)[:-1] + f',\n"frames": [\n{frames}\n]}}\n', "utf-8")


if __name__ == "__main__":
    sys.exit(main())
