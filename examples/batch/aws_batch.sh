#!/bin/sh
# Untested. The command of an AWS Batch array job of ten; meshes and library are on a file system that all tasks mount. JOBS is
# the number of cores in the job's definition: a container sees those of its machine.
#     aws batch submit-job --job-name sqmap --job-queue QUEUE --job-definition DEFINITION --array-properties size=10
set -eu
exec sqmap batch "$MANIFEST" -o "$OUT" --shard "$AWS_BATCH_JOB_ARRAY_INDEX/10" --jobs "${JOBS:-1}"
