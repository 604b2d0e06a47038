"""What the extra `book` promises: the programs that stage, run, render and judge the book."""

from importlib import import_module

for name in (
    "execute",
    "figures",
    "graph",
    "pairs",
    "paper",
    "reference",
    "render",
    "stage",
):
    import_module(f"cmtof_book.{name}")
for program in ("jupyter_book.cli.main", "jupytext.cli", "snakemake.cli"):
    import_module(program)
