"""What the extra `rooms` promises: furnished rooms, rendered by the command before."""

from pathlib import Path

assert list(Path("rooms").rglob("*.hdf5"))
