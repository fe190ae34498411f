// Processor time of a probe on a model at layer 3, by poses that touch; a line for scripts to read. speed.mjs does the same.
// usage: speed MODEL PROBE_MODEL      the probe: the vertices of the second model
#define _POSIX_C_SOURCE 200809L  // clock_gettime
#include <sqmap.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { k_rounds = 40, k_poses = 25, k_repeats = 20 };

static void check(sqmap_code code)
{
    if (code == SQMAP_OK) return;
    fprintf(stderr, "%s: %s\n", sqmap_last_error()->element, sqmap_last_error()->message);
    exit(1);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char** argv)
{
    if (argc != 3) return 64;
    sqmap_model model, other;
    check(sqmap_open(argv[1], &model));
    check(sqmap_open(argv[2], &other));
    sqmap_facts facts = {.size = sizeof facts}, tool = {.size = sizeof tool};
    check(sqmap_model_facts(model, &facts));
    check(sqmap_model_facts(other, &tool));
    double* vertices = malloc((size_t)24 * tool.vertices);
    check(sqmap_triangles(other, vertices, NULL, NULL));
    for (uint32_t i = 0; i < 3 * tool.vertices; ++i)
        vertices[i] = (vertices[i] - tool.centre[i % 3]) * facts.r_max / tool.r_max + facts.centre[i % 3];
    sqmap_probe probe;
    const sqmap_points points = {sizeof points, vertices, tool.vertices, NULL};
    check(sqmap_make_probe(&points, &probe));
    double best = 1e9, all = 0;
    size_t found = 0;
    for (int round = 0; round < k_rounds; ++round) {
        const double begin = seconds();
        found = 0;
        for (int i = 0; i < k_poses * k_repeats; ++i) {
            const sqmap_pose pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {facts.r_max * 0.03 * (i % k_poses), 0, 0}};
            const sqmap_bodies bodies = {sizeof bodies, {model, {0}, NULL}, {{0}, probe, &pose}};
            sqmap_contact_list list = {.size = sizeof list};
            check(sqmap_query_probe(&bodies, NULL, &list));
            found += list.found;
        }
        const double taken = seconds() - begin;
        if (taken < best) best = taken;
        all += taken;
    }
    const double count = k_poses * k_repeats;
    printf("%.2f us a probe of %u points, mean %.2f, %zu contacts\n", 1e6 * best / count, tool.vertices,
           1e6 * all / count / k_rounds, found);
    return 0;
}
