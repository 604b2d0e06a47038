"""What the extra `train` promises: learned methods, and the training of new weights."""

import json
import subprocess
import sys
from pathlib import Path

stage = {"name": "a", "crops": 4, "crop": 32, "batch": 2, "noise": [30, 60], "rate": [2e-3, 1e-3]}
recipe = {"stages": [stage], "rooms": None, "validation_views": 2}
Path("own.yml").write_text(json.dumps(recipe))
for words in ("evaluate wall.npz --method fast-scnn", "train own.yml --accelerator cpu -o run"):
    subprocess.run([sys.executable, "-m", "cmtof.cli", *words.split()], check=True)
assert list(Path("run").rglob("*.safetensors"))
