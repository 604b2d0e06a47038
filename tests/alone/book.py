"""What the extra `book` promises: the programs that stage, run, render and judge the book."""

from importlib import import_module

for program in (
    "cmtof_book.execute",
    "cmtof_book.figures",
    "cmtof_book.graph",
    "cmtof_book.pairs",
    "cmtof_book.paper",
    "cmtof_book.reference",
    "cmtof_book.render",
    "cmtof_book.stage",
    "jupyter_book.cli.main",
    "jupytext.cli",
    "snakemake.cli",
):
    import_module(program)
