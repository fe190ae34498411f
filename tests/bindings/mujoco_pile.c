// A pile of animals in MuJoCo, with its hulls and with sqmap's contacts: three seconds each. Prints a line for each.
// usage: mujoco_pile MODEL.xml FOLDER      exit 1 where with the override a body leaves the pit or sinks into another; 77 without
// MODEL.xml
#include "sqmap_mujoco.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const double k_time = 3, k_last = 0.5;

typedef struct Run {
    double height;   ///< m, of the bodies' centres of mass, mean at the end
    double outside;  ///< m, how far a body's centre is from the axis at most
    double jitter;   ///< m, largest motion of a body in a step of the last half second
    double deepest;  ///< m, contact between two meshes in the last half second
    double seconds;  ///< of this processor
    int contacts;    ///< at the end
} Run;

static double distance(const double* a, const double* b)
{
    return sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
}

static void watch(const mjModel* m, const mjData* d, const double* before, Run* run)
{
    for (int b = 1; b < m->nbody; ++b) run->jitter = fmax(run->jitter, distance(d->xipos + 3 * b, before + 3 * b));
    for (int i = 0; i < d->ncon; ++i) {
        const mjContact* c = &d->contact[i];
        if (m->geom_type[c->geom1] == mjGEOM_MESH && m->geom_type[c->geom2] == mjGEOM_MESH)
            run->deepest = fmax(run->deepest, -c->dist);
    }
}

static Run simulate(const mjModel* m)
{
    enum { k_max_bodies = 64 };
    double before[3 * k_max_bodies];
    mjData* d = mj_makeData(m);
    Run run = {0};
    const clock_t started = clock();
    while (d->time < k_time) {
        memcpy(before, d->xipos, sizeof(double) * 3 * (size_t)m->nbody);
        mj_step(m, d);
        if (d->time >= k_time - k_last) watch(m, d, before, &run);
    }
    run.seconds = (double)(clock() - started) / CLOCKS_PER_SEC;
    for (int b = 1; b < m->nbody; ++b) {
        const double* at = d->xipos + 3 * b;
        run.height += at[2] / (m->nbody - 1);
        run.outside = fmax(run.outside, hypot(at[0], at[1]));
    }
    run.contacts = d->ncon;
    mj_deleteData(d);
    return run;
}

static void print(const char* name, Run r)
{
    printf(
        "%-16s mean height %.1f mm, farthest %.0f mm; last half second: %.3f mm a step, penetration %.3f mm; %d contacts, %.1f s "
        "for %.0f\n",
        name, 1e3 * r.height, 1e3 * r.outside, 1e3 * r.jitter, 1e3 * r.deepest, r.contacts, r.seconds, k_time);
}

int main(int argc, char** argv)
{
    if (argc != 3) return 64;
    char why[1000] = "";
    mjModel* m = mj_loadXML(argv[1], NULL, why, sizeof why);
    if (m == NULL) {
        printf("no animals are here: %s\n", why);
        return 77;
    }
    print("MuJoCo's hulls", simulate(m));
    const sqmap_mujoco_options options = {.size = sizeof options, .folder = argv[2]};
    sqmap_mujoco* override = NULL;
    if (sqmap_mujoco_install(m, &options, &override) != SQMAP_OK) {
        fprintf(stderr, "%s: %s\n", sqmap_last_error()->element, sqmap_last_error()->message);
        return 1;
    }
    const Run run = simulate(m);
    print("sqmap's contacts", run);
    sqmap_mujoco_remove(override);
    mj_deleteModel(m);
    return run.outside < 0.3 && run.deepest < 2e-3 ? 0 : 1;
}
