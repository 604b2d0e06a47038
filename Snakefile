# The graph from notebooks to the book. Run it by `make book`, or look at it by
#   .venv/bin/snakemake --config profile=ci --dry-run
# Every notebook is a job of its own; what it depends on is worked out by `cmtof_book.graph`.
import json
import os
import shutil
from pathlib import Path

from cmtof_book import graph

PROFILE = config.get("profile", "book")


configfile: f"configs/{PROFILE}.yml"


SIZES = config["notebooks"] or {}
# a reader's own parameters, as in `make figure F=fig13 P="repeats=6"`: built apart from the book
OWN = graph.parameters_from_text(os.environ.get("P", ""))
BUILD = config.get("build", "build/own" if OWN else f"build/{PROFILE}")
PYTHON = ".venv/bin/python"
NOTEBOOKS = graph.notebooks()
# what the book is built from beside the notebooks; its guide to the hardware shows the rig
CHAPTERS = [
    str(path)
    for pattern in ("_*.yml", "src/cmtof/hardware/rig.*", "book/**/*")
    for path in sorted(Path().glob(pattern))
    if path.is_file()
]


def parameters_of(wildcards):
    parameters = {**(SIZES.get(wildcards.notebook) or {}), "profile": PROFILE, **OWN}
    return json.dumps(parameters, sort_keys=True)


# Chapters that take longest begin first, or one core would have to wait for them at the end; beside
# the first, which compiles the loops for all, begin some that need none of them.
LONG = (
    "10_methods",
    "08_network",
    "17_precision_sweep",
    "19_gage_blocks",
    "16_stereo",
    "05_simulation",
    "21_scanned_scenes",
    "20_mhz_camera",
    "12_robustness",
    "11_surfaces",
    "09_limits",
    "07_captures",
    "15_scan",
    "06_scenes",
    "03_wraps",
)
PRIORITIES = {name: len(LONG) - place for place, name in enumerate(LONG)}


wildcard_constraints:
    notebook="|".join(NOTEBOOKS),


# an unfinished book is none, though its folder is there
if Path(BUILD, "html").is_dir() and not Path(BUILD, "html", "index.html").is_file():
    shutil.rmtree(Path(BUILD, "html"))


rule all:
    input:
        f"{BUILD}/html",
        # asked for by name: Snakemake lets what lies between inputs and book be lost
        expand(f"{BUILD}/notebooks/{{notebook}}.ipynb", notebook=NOTEBOOKS),
        expand(f"{BUILD}/results/{{notebook}}", notebook=NOTEBOOKS),


rule notebook:
    input:
        lambda wildcards: graph.inputs(f"notebooks.{wildcards.notebook}"),
        "environment.lock",
        "src/cmtof_book/execute.py",
        "tools/execute.sh",
    output:
        executed=f"{BUILD}/notebooks/{{notebook}}.ipynb",
        results=directory(f"{BUILD}/results/{{notebook}}"),
    params:
        parameters=parameters_of,
        work=f"{BUILD}/failed/{{notebook}}",
    priority: lambda wildcards: PRIORITIES.get(wildcards.notebook, 0)
    shell:
        "tools/execute.sh notebooks/{wildcards.notebook}.py {params.parameters:q} {params.work:q}"
        " {output.executed} {output.results}"


rule laboratory:
    input:
        graph.inputs("cmtof_book.laboratory"),
    output:
        directory(f"{BUILD}/laboratory"),
    shell:
        "mkdir {output}; {PYTHON} -m cmtof_book.laboratory {output}"


rule stage:
    input:
        laboratory=f"{BUILD}/laboratory",
        executed=expand(f"{BUILD}/notebooks/{{notebook}}.ipynb", notebook=NOTEBOOKS),
        results=expand(f"{BUILD}/results/{{notebook}}", notebook=NOTEBOOKS),
        chapters=CHAPTERS,
        tool=graph.inputs("cmtof_book.stage"),
    output:
        directory(f"{BUILD}/stage"),
    shell:
        "mkdir -p {output}/notebooks {output}/book/{{claims,figures,_static/{{numbers,scenes}}}};"
        " tar -cf - {input.chapters:q} | tar -xf - -C {output};"
        " find {input.results} -name '*.png' -o -name '*.svg' | xargs cp -t {output}/book/figures;"
        " find {input.results} -name '*_*.csv' | xargs cp -t {output}/book/_static/numbers;"
        " find {input.results} -name '*_*.js' | xargs cp -t {output}/book/_static/scenes;"
        " cp {input.laboratory}/* {output}/book/_static/laboratory;"
        " {PYTHON} -m cmtof_book.stage {BUILD} {output} {input.executed}"


# every warning is an error; the log without colours, which are for a terminal
rule book:
    input:
        f"{BUILD}/stage",
        "environment.lock",
        graph.inputs("cmtof_book.render"),
    output:
        directory(f"{BUILD}/html"),
    log:
        f"{BUILD}/book.log",
    params:
        built=f"{BUILD}/sphinx",
        sources=expand("notebooks/{notebook}.ipynb", notebook=NOTEBOOKS),
    shell:
        "rm -rf {params.built};"
        " .venv/bin/jupyter-book build {input[0]} -W -n --keep-going -q --path-output {params.built} 2>&1"
        " | sed $'s/\\x1b\\[[0-9;]*m//g' > {log} || {{ grep -E 'WARNING|ERROR' {log} || cat {log};"
        " echo 'The book did not build; warnings count as errors. Log: {log}'; exit 1; }} >&2;"
        " mv {params.built}/_build/html {output} && rm -r {params.built};"
        " cp {params.sources} {output}/_sources/notebooks;"  # without the outputs that pages show
        " {PYTHON} -m cmtof_book.render {output}"
