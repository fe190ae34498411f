// The plugin of MuJoCo 3 against a stub of its interface: a box, whose distances are known.
// usage: mujoco3_test FOLDER
#include <math.h>
#include <mujoco/mujoco.h>
#include <sqmap.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mjpPlugin enrolled;
static int enrolled_count, warnings;
static char configured[2][1024];  ///< the model of each instance

void mjp_defaultPlugin(mjpPlugin* plugin) { memset(plugin, 0, sizeof *plugin); }

int mjp_registerPlugin(const mjpPlugin* plugin)
{
    enrolled = *plugin;
    return enrolled_count++;
}

void mju_warning(const char* format, ...)
{
    va_list list;
    va_start(list, format);
    vprintf(format, list);
    va_end(list);
    puts("");
    ++warnings;
}

const char* mj_getPluginConfig(const mjModel* m, int instance, const char* attribute)
{
    (void)m;
    return strcmp(attribute, "model") == 0 ? configured[instance] : NULL;
}

static void expect(int holds, const char* claim)
{
    if (holds) return;
    printf("not so: %s\n", claim);
    exit(1);
}

static const double k_half[3] = {0.3, 0.2, 0.1}, k_centre[3] = {1, -2, 0.5};

static void save_box(const char* path)
{
    double xyz[24];
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) xyz[3 * i + k] = k_centre[k] + ((i >> k & 1) != 0 ? k_half[k] : -k_half[k]);
    const int64_t corners[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    const sqmap_mesh mesh = {sizeof mesh, xyz, 8, corners, 12};
    sqmap_model model;
    expect(sqmap_bake(&mesh, NULL, &model) == SQMAP_OK && sqmap_save(model, path) == SQMAP_OK, "a box is baked and saved");
    sqmap_close_model(model);
}

static double distance_to_box(const double* p)
{
    double outside = 0, inside = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double beyond = fabs(p[k] - k_centre[k]) - k_half[k];
        outside += beyond > 0 ? beyond * beyond : 0;
        inside = fmax(inside, beyond);
    }
    return outside > 0 ? sqrt(outside) : inside;
}

/// Points about the box, far ones among them, none where its distance has an edge inside.
static void compare(const mjData* d, const mjtNum* numbers)
{
    for (int i = 0; i < 1000; ++i) {
        double p[3], gradient[3], slope[3];
        for (int k = 0; k < 3; ++k) p[k] = k_centre[k] + (fmod(i * (0.1031 + 0.1711 * k), 1) - 0.5) * (i % 2 != 0 ? 1 : 8);
        const double expected = distance_to_box(p);
        expect(fabs(enrolled.sdf_distance(p, d, 0) - expected) < 1e-6 * (1 + fabs(expected)), "distances are those of the box");
        const double early = enrolled.sdf_staticdistance(p, numbers);
        expect(
            early * expected > 0 && fabs(early) < 1.0001 * fabs(expected) + 1e-6 && fabs(early) > 0.4999 * fabs(expected) - 1e-6,
            "the compiler's distances have the sign, and are no longer");
        if (expected < 0) continue;
        enrolled.sdf_gradient(gradient, p, d, 0);
        for (int k = 0; k < 3; ++k) {
            double q[3] = {p[0], p[1], p[2]};
            q[k] += 1e-6;
            slope[k] = (distance_to_box(q) - expected) / 1e-6;
            expect(fabs(gradient[k] - slope[k]) < 1e-3, "gradients are the slope");
        }
    }
}

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    snprintf(configured[0], sizeof configured[0], "%s/box.sqmap", argv[1]);
    snprintf(configured[1], sizeof configured[1], "%s/none.sqmap", argv[1]);
    save_box(configured[0]);
    expect(enrolled_count == 1 && strcmp(enrolled.name, "sqmap.sdf") == 0 && (enrolled.capabilityflags & mjPLUGIN_SDF) != 0,
           "the plugin enrolls itself");
    expect(enrolled.nattribute == 1 && enrolled.nstate(NULL, 0) == 0, "it has one attribute and no state");
    uintptr_t slots[2] = {0}, copied[2] = {0};
    mjData data = {slots}, other = {copied};
    expect(enrolled.init(NULL, &data, 0) == 0 && warnings == 0, "an instance opens its model");
    expect(enrolled.init(NULL, &data, 1) == -1 && warnings == 1, "one without its file is refused, and it says so");
    const char *names[] = {"model"}, *values[] = {configured[0]};
    mjtNum numbers[1] = {0}, box[6];
    enrolled.sdf_attribute(numbers, names, values);
    expect(numbers[0] == (double)slots[0], "a model is opened once");
    enrolled.sdf_aabb(box, numbers);
    for (int k = 0; k < 3; ++k)
        expect(fabs(box[k] - k_centre[k]) < 1e-6 && box[3 + k] > k_half[k] && box[3 + k] < k_half[k] + 0.02,
               "its box is a little larger than the surface's");
    enrolled.copy(&other, NULL, &data, 0);
    enrolled.reset(NULL, NULL, NULL, 0);
    enrolled.compute(NULL, &data, 0, mjPLUGIN_SDF);
    compare(&data, numbers);
    compare(&other, numbers);
    puts("2,000 points agree");
    return 0;
}
