"""What the extra `networks` promises: every learned method that has weights, without torch."""

import json
from importlib.util import find_spec
from pathlib import Path

from cmtof.methods import METHODS

assert find_spec("torch") is None
learned = {name for name, one in METHODS.items() if one.state() == "trained"}
assert learned and learned <= json.loads(Path("all.json").read_text())["methods"].keys()
