"""What the extra `rooms` promises: furnished rooms, rendered."""

import subprocess
import sys
from pathlib import Path

words = "render --scenes 1 --views 1 --size 32x32 --workers 1 -o rooms"
subprocess.run([sys.executable, "-m", "cmtof.cli", *words.split()], check=True)
assert list(Path("rooms").rglob("*.hdf5"))
