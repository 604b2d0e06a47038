"""What the extra `train` promises: learned methods, and the training of new weights."""

from pathlib import Path

assert list(Path("run").rglob("*.safetensors"))
