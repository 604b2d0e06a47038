"""What the extra `networks` promises: every learned method that has weights, without torch."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from cmtof.methods import METHODS

assert find_spec("torch") is None
unwrap = "unwrap wall.nc -o wall_depth.nc --method fast-scnn"
evaluate = "evaluate wall.npz --method all --json all.json"
for words in (unwrap, evaluate):
    subprocess.run([sys.executable, "-m", "cmtof.cli", *words.split()], check=True)
learned = {name for name, one in METHODS.items() if one.state() == "trained"}
assert learned and learned <= json.loads(Path("all.json").read_text())["methods"].keys()
