"""Count methods over all test frames and store the counts where the chapters find them.

    python -m cmtof_book.tables [--protocol released|full] [--noise SIGMA] [--again] [METHOD...]
    python -m cmtof_book.tables --runs FOLDER

Without names: every method and reference. Only methods that are new or have other weights are
counted, unless ``--again`` is given. With ``--runs`` weights are counted by their folders' names.
"""

import argparse
import hashlib
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).resolve().parents[2] / "book" / "results"


def main(arguments: Sequence[str] | None = None) -> None:
    """Count and store."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("methods", nargs="*", metavar="METHOD")
    parser.add_argument("--protocol", default="released", choices=("released", "full"))
    parser.add_argument("--noise", type=float, default=1200.0, help="Gaussian sigma, counts")
    parser.add_argument("--again", action="store_true", help="count these methods again")
    parser.add_argument("--runs", type=Path, help="folder of trainings")
    parser.add_argument("--into", type=Path, default=RESULTS, help="folder of the counts")
    given = parser.parse_args(arguments)
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")  # before NumPy and torch are loaded
    from cmtof.evaluation import Evaluation
    from cmtof.frame import held_out_frames
    from cmtof.methods import METHODS, find_method, names_of
    from cmtof.network.weights import read_card, weights_path

    names = given.methods or [
        *names_of("all", given.protocol),
        *(name for name, method in METHODS.items() if method.kind == "reference"),
    ]
    names = [find_method(name).name for name in names]
    rows = {name: (name, weights_path(name, given.protocol)) for name in names}
    if given.runs:
        found = sorted(given.runs.glob(f"*/*.{given.protocol}.safetensors"))
        rows = {path.parent.name: (read_card(path).model, path) for path in found}
    settings = {"protocol": given.protocol, "noise": given.noise, "seed": 0}
    path = given.into / f"table{1 if given.runs else 2}_{given.protocol}_{given.noise:g}.json"
    held: dict[str, Any] = json.loads(path.read_text("utf-8")) if path.is_file() else {}
    if held.get("settings") != settings:
        command = f"python -m cmtof_book.tables --protocol {given.protocol} --noise {given.noise:g}"
        command += " --runs FOLDER" if given.runs else ""
        held = {"command": command, "settings": settings, "weights": {}, "cards": {}, "frames": []}
    frames = held_out_frames()
    for name, (method, file) in rows.items():
        weights = hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else ""
        counted = held["frames"] and name in held["frames"][0]["methods"]
        if counted and held["weights"].get(name, "") == weights and not given.again:
            continue
        evaluation = Evaluation([method], **settings)
        if weights:
            held["weights"][name], evaluation.options = weights, {"weights": file}
        add(held, name, evaluation.add_all(frames))
        if given.runs:
            held["cards"][name] = read_card(file).model_dump(exclude={"sha256"})
        write(held, path)


def add(held: dict[str, Any], name: str, evaluation: Any) -> None:
    """Join the counts of a method over all frames with those of the others, under a name."""
    counts = evaluation.counts()
    ((method, scores),) = evaluation.report()["methods"].items()
    old = held["frames"] or [{"methods": {}} for _ in counts]
    held["frames"] = [
        new | {"methods": before["methods"] | {name: new["methods"][method]}}
        for before, new in zip(old, counts, strict=True)
    ]
    print(name, {key: round(rate, 4) for key, rate in scores.items()}, flush=True)


def write(held: dict[str, Any], path: Path) -> None:
    """Store counts, one frame a line, with their hash."""
    from cmtof import __version__
    from cmtof.evaluation import digest
    from cmtof.files import written_whole

    frames = ",\n".join(json.dumps(frame) for frame in held["frames"])
    head = {key: part for key, part in held.items() if key != "frames"}
    head |= {"version": __version__, "sha256": digest(held["frames"])}
    with written_whole(path) as part:
        part.write_text(json.dumps(head)[:-1] + f',\n"frames": [\n{frames}\n]}}\n', "utf-8")


if __name__ == "__main__":
    main()
