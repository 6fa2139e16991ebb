#!/bin/sh
# Builds an archive on a Slurm cluster: an array of jobs for each stage, each after the one before, and the merge at the end.
#
#   slurm.sh WORK OUT.pmtiles DEM… [options of `terrain-ingest plan`]
#
# WORK is a folder that all nodes share, or a bucket. SBATCH_* variables of the environment say account, partition and time.
# A stage of more jobs than the cluster's MaxArraySize needs fewer, larger jobs: --leaves 1024.
set -eu
work=$1
output=$2
shift 2

terrain-ingest plan "$@" --work "$work" --json |
    sed -n 's/.*"stage": "\([a-z]*\)".*/\1/p; s/.*"jobs": \([0-9]*\).*/\1/p' |
    {
        after=
        while read -r stage && read -r jobs; do
            after=$(sbatch --parsable --job-name="terrain-$stage" --array="0-$((jobs - 1))" $after \
                --wrap "terrain-ingest build --work '$work' --job $stage/\$SLURM_ARRAY_TASK_ID --jobs \${SLURM_CPUS_PER_TASK:-1}")
            after="--dependency=afterok:${after%%;*}"
        done
        sbatch --parsable --job-name=terrain-merge $after --wrap "terrain-ingest merge --work '$work' -o '$output'"
    }
