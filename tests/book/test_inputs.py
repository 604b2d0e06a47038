"""What `configs/inputs.yml` says a notebook reads, against what the notebook's code names."""

import ast
import re

from pytest import mark

from cmtof.files import read_document
from cmtof_book import RESULTS, ROOT, graph

DECLARED = read_document(ROOT / "configs" / "inputs.yml")
STORED = [file.relative_to(RESULTS) for file in RESULTS.rglob("*.*")]
NAMES = " ".join(map(str, STORED))


def code_of(stem):
    """Syntax nodes of a notebook; of its parameters only the folder of results names files."""
    tree = ast.parse(graph.path_of(f"notebooks.{stem}").read_text("utf-8"))
    for statement in tree.body:
        parameter = isinstance(statement, ast.AnnAssign)
        if not parameter or ast.unparse(statement.target) == "results":
            yield from ast.walk(statement)


def pattern(template, field):
    """Regular expression of an f-string whose fields look so."""
    return "".join(
        str(part.value) if isinstance(part, ast.Constant) else field
        for part in template.values
    )


def named_results(stem):
    """Stored files that a notebook names, in f-strings by its own words, or by their folder."""
    nodes = list(code_of(stem))
    texts = [str(node.value) for node in nodes if isinstance(node, ast.Constant)]
    words = {text.rpartition("/")[2] for text in texts}
    words = {word for word in words - {""} if word in NAMES}
    templates = [
        node
        for node in nodes
        if isinstance(node, ast.JoinedStr)
        and re.fullmatch(r"[\w.]+", pattern(node, ""))
    ]
    # a word may be a negative number; an f-string may be filled with another one
    word = f"-?(?:{'|'.join(words)})"
    field = "|".join([word, *(pattern(one, word) for one in templates)])
    names = "|".join([word, *(pattern(one, f"(?:{field})") for one in templates)])
    return {
        str(file)
        for file in STORED
        if file.parent.name in words or re.fullmatch(names, file.name)
    }


@mark.parametrize("stem", graph.notebooks())
def test_the_stored_results_that_a_notebook_reads_are_listed(stem):
    assert sorted(DECLARED.get(stem, {}).get("results", [])) == sorted(
        named_results(stem)
    )


def test_the_notebooks_that_read_data_are_listed():
    listed = {f"notebooks.{stem}" for stem, read in DECLARED.items() if "data" in read}
    readers = graph.imports().find_modules_that_directly_import("cmtof.captures")
    assert listed == {module for module in readers if module.startswith("notebooks")}
