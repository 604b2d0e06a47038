# What costs more than a build: methods over all test frames, a job for each protocol and noise, and
# trainings, a job each.
#   .venv/bin/snakemake -s cluster/sweeps.smk --cores 2 table2
#   .venv/bin/snakemake -s cluster/sweeps.smk --profile cluster/slurm train --config recipe=gpu
# Options by --config: methods, protocols, noises, models (words separated by commas), recipe.
PYTHON = ".venv/bin/python"
SWEEP = "build/sweep/{protocol}_{noise}"


def words(name, default):
    return str(config.get(name, default)).split(",")


METHODS = words("methods", "crt,beat,beat-guided,spatial,region,phasor,kde,mrf,surfaces")
MODELS = words("models", "u-net,one-step,deep-tof,rapid,fast-scnn,fast-scnn-ce,fast-scnn-light")


rule table2:
    input:
        expand(
            SWEEP,
            protocol=words("protocols", "released,full"),
            noise=words("noises", "1200"),
        ),


rule count:
    output:
        touch(SWEEP),
    params:
        methods=METHODS,
    shell:
        "{PYTHON} -m cmtof_book.tables --protocol {wildcards.protocol} --noise {wildcards.noise}"
        " {params.methods}"


rule train:
    input:
        expand("runs/{model}/done", model=MODELS),


rule network:
    output:
        touch("runs/{model}/done"),
    params:
        recipe=config.get("recipe", "table1"),
    resources:
        mem_mb=8000,
    shell:
        ".venv/bin/cmtof train {params.recipe} --model {wildcards.model} -o runs/{wildcards.model}"
        " --resume --quiet"
