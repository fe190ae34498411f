// MuJoCo with and without sqmap's contacts: ten seconds of a model. Prints a line for each.
// usage: mujoco_test MODEL.xml BODY FOLDER      exit 1 where the body with the override leaves, or jitters by more than 0.1 mm
#include "sqmap_mujoco.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

typedef struct Run {
    double moved;        ///< m, of the body, from where it began
    double sideways;     ///< m, of it, across the axis
    double jitter;       ///< m, largest change of its position from step to step in the last second
    double penetration;  ///< m, deepest contact of the last second
    double seconds;      ///< of this processor
    int contacts;        ///< at the end
} Run;

static Run simulate(const mjModel* m, int body)
{
    mjData* d = mj_makeData(m);
    mj_forward(m, d);
    double begin[3], last[3];
    memcpy(begin, d->xpos + 3 * body, sizeof begin);
    Run run = {0};
    const clock_t started = clock();
    while (d->time < 10) {
        memcpy(last, d->xpos + 3 * body, sizeof last);
        mj_step(m, d);
        if (d->time < 9) continue;
        const double* now = d->xpos + 3 * body;
        run.jitter = fmax(run.jitter, sqrt(pow(now[0] - last[0], 2) + pow(now[1] - last[1], 2) + pow(now[2] - last[2], 2)));
        for (int i = 0; i < d->ncon; ++i) run.penetration = fmax(run.penetration, -d->contact[i].dist);
    }
    run.seconds = (double)(clock() - started) / CLOCKS_PER_SEC;
    const double* end = d->xpos + 3 * body;
    run.sideways = hypot(end[0] - begin[0], end[1] - begin[1]);
    run.moved = hypot(run.sideways, end[2] - begin[2]);
    run.contacts = d->ncon;
    mj_deleteData(d);
    return run;
}

static void print(const char* name, Run r)
{
    printf(
        "%-16s moved %.2f mm, sideways %.3f mm; last second: %.4f mm a step, penetration %.4f mm; %d contacts, %.1f s for 10\n",
        name, 1e3 * r.moved, 1e3 * r.sideways, 1e3 * r.jitter, 1e3 * r.penetration, r.contacts, r.seconds);
}

int main(int argc, char** argv)
{
    if (argc != 4) return 64;
    char why[1000] = "";
    mjModel* m = mj_loadXML(argv[1], NULL, why, sizeof why);
    if (m == NULL) {
        fprintf(stderr, "%s\n", why);
        return 1;
    }
    const int body = mj_name2id(m, mjOBJ_BODY, argv[2]);
    print("MuJoCo's hulls", simulate(m, body));
    const sqmap_mujoco_options options = {.size = sizeof options, .folder = argv[3]};
    sqmap_mujoco* override = NULL;
    if (sqmap_mujoco_install(m, &options, &override) != SQMAP_OK) {
        fprintf(stderr, "%s: %s\n", sqmap_last_error()->element, sqmap_last_error()->message);
        return 1;
    }
    const Run run = simulate(m, body);
    print("sqmap's contacts", run);
    sqmap_mujoco_remove(override);
    const double again = simulate(m, body).moved;
    printf("removed: moved %.2f mm\n", 1e3 * again);
    mj_deleteModel(m);
    return run.sideways < 1e-3 && run.jitter < 1e-4 && run.penetration < 5e-4 ? 0 : 1;
}
