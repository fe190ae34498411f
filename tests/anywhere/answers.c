// Hashes of a model's answers at 100,000 points, a line for each layer: the same on every machine, through every door. The same
// points and hashes are computed by answers.py and answers.mjs.
// usage: answers MODEL
#include <sqmap.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { k_count = 100000 };

static uint32_t crc_table[256];

static void make_table(void)
{
    for (uint32_t i = 0; i < 256; ++i) {
        uint32_t c = i;
        for (int k = 0; k < 8; ++k) c = (c & 1) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
        crc_table[i] = c;
    }
}

/// CRC-32 as zlib's, from one array to the next.
static uint32_t crc(uint32_t seed, const void* data, size_t size)
{
    const unsigned char* at = data;
    uint32_t c = ~seed;
    for (size_t i = 0; i < size; ++i) c = crc_table[(c ^ at[i]) & 255] ^ (c >> 8);
    return ~c;
}

/// NaNs have no sign and no payload that two machines need share.
static uint32_t crc_of_numbers(uint32_t seed, double* values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (isnan(values[i])) values[i] = -1e308;
    return crc(seed, values, count * sizeof *values);
}

/// In [0, 1): of the i-th number, by integers alone.
static double uniform(uint32_t i)
{
    uint32_t h = i * 0x9e3779b1U;
    h = (h ^ (h >> 16)) * 0x85ebca6bU;
    h = (h ^ (h >> 13)) * 0xc2b2ae35U;
    return (h ^ (h >> 16)) / 4294967296.0;
}

static void check(sqmap_code code)
{
    if (code == SQMAP_OK) return;
    const sqmap_error* e = sqmap_last_error();
    fprintf(stderr, "%s: %s %s; %s\n", e->name, e->element, e->message, e->cure);
    exit(1);
}

/// One in four anywhere about the object, the others near a vertex where the model has them.
static void make_points(sqmap_model model, const sqmap_facts* facts, double* xyz)
{
    double* vertices = malloc(((size_t)3 * facts->vertices + 1) * sizeof *vertices);
    if (facts->has_exact) check(sqmap_triangles(model, vertices, NULL, NULL));
    for (uint32_t i = 0; i < k_count; ++i)
        for (uint32_t k = 0; k < 3; ++k) {
            const double u = 2 * uniform(3 * i + k) - 1;
            xyz[3 * i + k] = i % 4 == 0 || !facts->has_exact
                                 ? facts->centre[k] + 1.25 * facts->radius * u
                                 : vertices[3 * (i % facts->vertices) + k] + 0.03125 * facts->r_max * u;
        }
    xyz[5] = INFINITY;
    xyz[7] = 1e30;
    free(vertices);
}

static double normal[3 * k_count], closest[3 * k_count], depth[k_count], xyz[3 * k_count];
static int32_t part[k_count];
static uint32_t triangle[k_count];
static uint8_t contact[k_count], certain[k_count], status[k_count];

static void print_layer(sqmap_model model, const sqmap_points* points, int layer)
{
    const sqmap_query_options options = {.size = sizeof options, .layer = layer};
    sqmap_contacts out = {sizeof out, contact, depth, normal, closest, part, certain, status, 0};
    check(sqmap_query_points(model, points, &options, &out));
    uint32_t h = crc(0, contact, sizeof contact);
    h = crc_of_numbers(h, depth, k_count);
    h = crc_of_numbers(h, normal, (size_t)3 * k_count);
    h = crc_of_numbers(h, closest, (size_t)3 * k_count);
    h = crc(h, part, sizeof part);
    h = crc(h, certain, sizeof certain);
    printf("layer %d    %08x  %zu inside\n", layer, (unsigned)crc(h, status, sizeof status), out.contacts);
}

static void print_distances(sqmap_model model, const sqmap_points* points, double band)
{
    const sqmap_query_options options = {.size = sizeof options, .band = band};
    sqmap_distances out = {sizeof out, depth, normal, closest, part, certain, status};
    check(sqmap_signed_distances(model, points, &options, &out));
    uint32_t h = crc_of_numbers(0, depth, k_count);
    h = crc_of_numbers(h, normal, (size_t)3 * k_count);
    h = crc_of_numbers(h, closest, (size_t)3 * k_count);
    h = crc(h, part, sizeof part);
    h = crc(h, certain, sizeof certain);
    printf("distances  %08x  band %s\n", (unsigned)crc(h, status, sizeof status), band > 0 ? "infinite" : "baked");
}

static void print_closest(sqmap_model model, const sqmap_points* points)
{
    sqmap_closest out = {sizeof out, closest, depth, triangle};
    check(sqmap_closest_points(model, points, NULL, &out));
    uint32_t h = crc_of_numbers(0, closest, (size_t)3 * k_count);
    h = crc_of_numbers(h, depth, k_count);
    printf("closest    %08x\n", (unsigned)crc(h, triangle, sizeof triangle));
}

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    make_table();
    sqmap_model model;
    check(sqmap_open(argv[1], &model));
    sqmap_facts facts = {.size = sizeof facts};
    check(sqmap_model_facts(model, &facts));
    make_points(model, &facts, xyz);
    const sqmap_points points = {sizeof points, xyz, k_count, NULL};
    for (int layer = SQMAP_LAYER_1; layer <= SQMAP_LAYER_EXACT; ++layer) print_layer(model, &points, layer);
    print_distances(model, &points, 0);
    print_distances(model, &points, INFINITY);
    if (facts.has_exact) print_closest(model, &points);
    check(sqmap_close_model(model));
    return 0;
}
