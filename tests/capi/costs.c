// Processor time of a point in batches of 10,000 and one a call, microseconds: the best of 15 rounds, a line for each function.
// The table of costs in docs/guide/c.md is of this program; tests/python/costs.py has the same points in Python. usage: costs
// MODEL      cc -O2 costs.c -lsqmap -o costs
#define _POSIX_C_SOURCE 200809L  // clock_gettime
#include <sqmap.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { k_points = 10000, k_rounds = 15 };

static double xyz[k_points][3], one[3 * k_points], other[3 * k_points];
static uint8_t contact[k_points];
static uint32_t triangle[k_points];
static sqmap_model model;

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

static void query(int which, size_t first, size_t count)
{
    const sqmap_points points = {.size = sizeof points, .xyz = xyz[first], .count = count};
    const sqmap_query_options options = {.size = sizeof options, .layer = which == 4 ? SQMAP_LAYER_EXACT : SQMAP_LAYER_3};
    sqmap_distances distances = {.size = sizeof distances, .distance = one, .gradient = other, .triangle = triangle};
    sqmap_closest closest = {.size = sizeof closest, .closest = other, .distance = one, .triangle = triangle};
    sqmap_contacts contacts = {.size = sizeof contacts, .contact = contact, .depth = one, .normal = other};
    if (which == 0) check(sqmap_exact_distances(model, &points, NULL, &distances));
    if (which == 1) check(sqmap_signed_distances(model, &points, NULL, &distances));
    if (which == 2) check(sqmap_closest_points(model, &points, NULL, &closest));
    if (which > 2) check(sqmap_query_points(model, &points, &options, &contacts));
}

int main(int argc, char** argv)
{
    static const char* const names[] = {"sqmap_exact_distances", "sqmap_signed_distances", "sqmap_closest_points",
                                        "sqmap_query_points", "sqmap_query_points, exact"};
    if (argc != 2) return 64;
    check(sqmap_open(argv[1], &model));
    sqmap_facts facts = {.size = sizeof facts};
    check(sqmap_model_facts(model, &facts));
    uint64_t state = 1;
    for (size_t i = 0; i < 3 * (size_t)k_points; ++i) {  // in the cube about the object's sphere
        state = state * 6364136223846793005u + 1442695040888963407u;
        xyz[i / 3][i % 3] = facts.centre[i % 3] + facts.radius * ((double)(state >> 11) * 0x1p-52 - 1);
    }
    for (int which = 0; which < 5; ++which) {
        double batch = 1e9, single = 1e9;
        for (int round = 0; round < k_rounds; ++round) {
            const double start = seconds();
            query(which, 0, k_points);
            const double middle = seconds();
            for (size_t i = 0; i < k_points; ++i) query(which, i, 1);
            const double end = seconds();
            if (middle - start < batch) batch = middle - start;
            if (end - middle < single) single = end - middle;
        }
        printf("%-27s %.2f in batches, %.2f one a call\n", names[which], 1e6 * batch / k_points, 1e6 * single / k_points);
    }
    check(sqmap_close_model(model));
    return 0;
}
