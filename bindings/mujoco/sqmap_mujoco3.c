// A baked model as a signed distance field of MuJoCo 3: compile this file into a shared library and load it with
// mj_loadPluginLibrary. Untested with MuJoCo itself: it is compiled and called against a stub of its interface.
//
//   <extension><plugin plugin="sqmap.sdf"><instance name="hand"><config key="model"
//   value="hand.sqmap"/></instance></plugin></extension> <asset><mesh name="hand"><plugin instance="hand"/></mesh></asset> <geom
//   type="sdf" mesh="hand"><plugin instance="hand"/></geom>
//
// MuJoCo's compiler asks for distances before an instance is there, and hands over numbers alone: the number of a model in the
// table of this process. Models stay open until the process ends.
#include <math.h>
#include <mujoco/mujoco.h>
#include <pthread.h>
#include <sqmap.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { k_max_models = 1024 };

typedef struct Field {
    char* path;
    sqmap_model model;
    double centre[3], half[3];  ///< of a box that holds the surface
} Field;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static Field fields[k_max_models];  ///< number n stands at n - 1; 0 is none
static int field_count;

/// A box about the vertices; of a model without triangles about its sphere. Wider than the surface by a hundredth, so that
/// MuJoCo's marching cubes see both sides of it.
static sqmap_code bound(Field* field)
{
    sqmap_facts facts = {.size = sizeof facts};
    sqmap_code code = sqmap_model_facts(field->model, &facts);
    if (code != SQMAP_OK) return code;
    double lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
        lo[k] = facts.centre[k] - facts.radius;
        hi[k] = facts.centre[k] + facts.radius;
    }
    if (facts.has_exact != 0) {
        double* xyz = malloc(sizeof(double) * 3 * facts.vertices);
        if (xyz == NULL) return SQMAP_E_MEMORY;
        code = sqmap_triangles(field->model, xyz, NULL, NULL);
        for (uint32_t i = 0; i < 3 * facts.vertices && code == SQMAP_OK; ++i) {
            lo[i % 3] = i < 3 ? xyz[i] : fmin(lo[i % 3], xyz[i]);
            hi[i % 3] = i < 3 ? xyz[i] : fmax(hi[i % 3], xyz[i]);
        }
        free(xyz);
    }
    for (int k = 0; k < 3; ++k) {
        field->centre[k] = 0.5 * (lo[k] + hi[k]);
        field->half[k] = 0.5 * (hi[k] - lo[k]) + 0.01 * facts.r_max;
    }
    return code;
}

/// The number of a model file, opened once; 0 with a warning where it cannot be.
static int number_of(const char* path)
{
    if (path == NULL || path[0] == 0) return 0;
    pthread_mutex_lock(&lock);
    int number = 1;
    while (number <= field_count && strcmp(fields[number - 1].path, path) != 0) ++number;
    const char* why = NULL;
    if (number > k_max_models) {
        why = "more than 1024 models";
    } else if (number > field_count) {
        Field field = {.path = malloc(strlen(path) + 1)};
        if (field.path != NULL && sqmap_open(path, &field.model) == SQMAP_OK && bound(&field) == SQMAP_OK) {
            strcpy(field.path, path);
            fields[field_count++] = field;
        } else {
            why = field.path == NULL ? "no memory" : sqmap_last_error()->message;
            free(field.path);
            sqmap_close_model(field.model);
        }
    }
    pthread_mutex_unlock(&lock);
    if (why == NULL) return number;
    mju_warning("sqmap.sdf: %s: %s", path, why);
    return 0;
}

/// Free space where there is no model. A band of 0 is the baked one: beyond it distances are bounds, and gradients zero.
static double signed_distance(int number, const mjtNum point[3], double band, mjtNum gradient[3])
{
    double distance = 1, along[3] = {0}, xyz[3] = {point[0], point[1], point[2]};
    if (number > 0) {
        const sqmap_points points = {sizeof points, xyz, 1, NULL};
        const sqmap_query_options options = {.size = sizeof options, .band = band};
        sqmap_distances answers = {.size = sizeof answers, .distance = &distance, .gradient = along};
        if (sqmap_signed_distances(fields[number - 1].model, &points, &options, &answers) != SQMAP_OK) distance = 1;
    }
    for (int k = 0; k < 3 && gradient != NULL; ++k) gradient[k] = along[k];
    return distance;
}

static const char* const attributes[] = {"model"};

static int no_state(const mjModel* m, int instance)
{
    (void)m, (void)instance;
    return 0;
}

static int start(const mjModel* m, mjData* d, int instance)
{
    const int number = number_of(mj_getPluginConfig(m, instance, attributes[0]));
    d->plugin_data[instance] = (uintptr_t)number;
    return number > 0 ? 0 : -1;
}

static void copy(mjData* to, const mjModel* m, const mjData* from, int instance)
{
    (void)m;
    to->plugin_data[instance] = from->plugin_data[instance];
}

static void reset(const mjModel* m, mjtNum* state, void* data, int instance) { (void)m, (void)state, (void)data, (void)instance; }

static void compute(const mjModel* m, mjData* d, int instance, int capability)
{
    (void)m, (void)d, (void)instance, (void)capability;
}

static mjtNum distance_at(const mjtNum point[3], const mjData* d, int instance)
{
    return signed_distance((int)d->plugin_data[instance], point, INFINITY, NULL);
}

static void gradient_at(mjtNum gradient[3], const mjtNum point[3], const mjData* d, int instance)
{
    signed_distance((int)d->plugin_data[instance], point, INFINITY, gradient);
}

static mjtNum static_distance_at(const mjtNum point[3], const mjtNum* numbers)
{
    return signed_distance((int)numbers[0], point, 0, NULL);
}

static void read_attributes(mjtNum numbers[], const char* names[], const char* values[])
{
    (void)names;
    numbers[0] = number_of(values[0]);
}

static void box_of(mjtNum box[6], const mjtNum* numbers)
{
    const int number = (int)numbers[0];
    for (int k = 0; k < 3; ++k) {
        box[k] = number > 0 ? fields[number - 1].centre[k] : 0;
        box[3 + k] = number > 0 ? fields[number - 1].half[k] : 1;
    }
}

/// As mjPLUGIN_LIB_INIT, whose form differs from version to version.
__attribute__((constructor)) static void enroll(void)
{
    mjpPlugin plugin;
    mjp_defaultPlugin(&plugin);
    plugin.name = "sqmap.sdf";
    plugin.nattribute = 1;
    plugin.attributes = attributes;
    plugin.capabilityflags |= mjPLUGIN_SDF;
    plugin.nstate = no_state;
    plugin.init = start;
    plugin.copy = copy;
    plugin.reset = reset;
    plugin.compute = compute;
    plugin.sdf_distance = distance_at;
    plugin.sdf_gradient = gradient_at;
    plugin.sdf_staticdistance = static_distance_at;
    plugin.sdf_attribute = read_attributes;
    plugin.sdf_aabb = box_of;
    mjp_registerPlugin(&plugin);
}
