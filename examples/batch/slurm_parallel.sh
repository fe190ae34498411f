#!/bin/bash
#SBATCH --job-name=sqmap
#SBATCH --cpus-per-task=2
#SBATCH --requeue
# All shards in one step, as many at once as it has cores: for clusters that allow few jobs.
#     sbatch --export=ALL,MANIFEST=meshes.csv,OUT=library,SHARDS=10 slurm_parallel.sh
set -eu
seq 0 $((SHARDS - 1)) | parallel --halt soon,fail=1 -j "${SLURM_CPUS_PER_TASK:-1}" \
  "${SQMAP:-sqmap}" batch "$MANIFEST" -o "$OUT" --shard {}/"$SHARDS" --jobs 1
