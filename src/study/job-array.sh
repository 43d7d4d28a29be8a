#!/bin/sh
# Jobs of a study. Slurm:  cd FOLDER && sbatch run.sh    (workers need `regatta` on their PATH, and this folder)
#                  A shell: ./run.sh [JOBS_AT_A_TIME]
# A job that has its result isn't done again.
#SBATCH --array=1-@TASKS@
#SBATCH --cpus-per-task=2
#SBATCH --job-name=regatta-study
# Slurm runs a copy of this file, from which the study's folder can't be known.
cd "${SLURM_SUBMIT_DIR:-$(dirname "$0")}" || exit 1
[ -f jobs.txt ] || { echo "no jobs.txt in $PWD: submit from the study's folder: cd FOLDER && sbatch run.sh" >&2; exit 1; }
one() {
    # Who starts this script trusts its jobs, too.
    [ -s "results/$1.json" ] || regatta study-run "jobs/$1.json" --trust
}
if [ -n "$SLURM_ARRAY_TASK_ID" ]; then
    # Each task does every @TASKS@th job: large and small ones alike.
    failed=0
    for id in $(awk -v task="$SLURM_ARRAY_TASK_ID" 'NR % @TASKS@ == task % @TASKS@' jobs.txt); do
        one "$id" || failed=1
    done
    exit $failed
else
    xargs -P "${1:-$(getconf _NPROCESSORS_ONLN)}" -I ID sh -c '[ -s results/ID.json ] || regatta study-run jobs/ID.json --trust' <jobs.txt
fi
