#!/bin/bash
#SBATCH --job-name=sqmap
#SBATCH --array=0-9
#SBATCH --cpus-per-task=1
#SBATCH --requeue
# A shard a task: the program reads its number and how many there are from Slurm's environment.
#     sbatch --export=ALL,MANIFEST=meshes.csv,OUT=library slurm.sh
set -eu
exec "${SQMAP:-sqmap}" batch "$MANIFEST" -o "$OUT"
