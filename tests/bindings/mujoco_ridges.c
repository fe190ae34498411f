// Two bars in MuJoCo whose ridges cross between their vertices: contacts of vertices have none, complete ones the depth. Two
// balls that overlap far: of hundreds of contacts as many as were asked for, the deepest among them. Boxes face on face rest, and towers of prisms.
#include "sqmap_mujoco.h"

#include <math.h>
#include <stdio.h>

static const char* xml =
    "<mujoco><asset>"
    "<mesh name='x' vertex='-3 0 -1 -3 1 0 -3 0 1 -3 -1 0 3 0 -1 3 1 0 3 0 1 3 -1 0'/>"
    "<mesh name='y' vertex='0 -3 -1 1 -3 0 0 -3 1 -1 -3 0 0 3 -1 1 3 0 0 3 1 -1 3 0'/>"
    "</asset><worldbody><geom type='mesh' mesh='x'/>"
    "<body name='upper'><freejoint/><geom type='mesh' mesh='y'/></body></worldbody></mujoco>";

static const double k_pi = 3.14159265358979323846;
static int failures;

static void expect(int holds, const char* claim)
{
    if (!holds) printf("not so: %s\n", claim);
    failures += !holds;
}

/// The contacts of the bars where the upper one's middle is at a height.
static int contacts_at(const mjModel* m, mjData* d, int is_complete, double height)
{
    const sqmap_mujoco_options options = {.size = sizeof options, .is_complete = is_complete};
    sqmap_mujoco* override = NULL;
    if (sqmap_mujoco_install(m, &options, &override) != SQMAP_OK) {
        printf("%s: %s\n", sqmap_last_error()->element, sqmap_last_error()->message);
        ++failures;
        return -1;
    }
    expect(sqmap_mujoco_meshes(override) == 2, "sqmap answers both meshes");
    mj_resetData(m, d);
    d->qpos[2] = height;
    mj_forward(m, d);
    sqmap_mujoco_remove(override);
    return d->ncon;
}

/// Two unit balls with a vertex at either pole, the upper one free.
static void write_balls(FILE* file)
{
    enum { k_rings = 16, k_around = 32 };
    fputs("<mujoco><asset><mesh name='ball' vertex='0 0 1 0 0 -1", file);
    for (int i = 1; i < k_rings; ++i)
        for (int j = 0; j < k_around; ++j) {
            const double down = k_pi * i / k_rings, around = 2 * k_pi * j / k_around;
            fprintf(file, " %.9f %.9f %.9f", sin(down) * cos(around), sin(down) * sin(around), cos(down));
        }
    fputs(
        "'/></asset><worldbody><geom type='mesh' mesh='ball'/><body><freejoint/><geom type='mesh' mesh='ball'/></body>"
        "</worldbody></mujoco>",
        file);
}

static mjModel* load(const char* path)
{
    char why[1000] = "";
    mjModel* m = mj_loadXML(path, NULL, why, sizeof why);
    if (m == NULL) fprintf(stderr, "%s\n", why);
    return m;
}

/// The depth of the deepest of the balls' contacts, at most so many of them; the upper ball's pole is 0.4 below the lower one's.
static double depth_of_balls(const mjModel* m, mjData* d, int max_contacts)
{
    const int limit = max_contacts > 0 ? max_contacts : mjMAXCONPAIR;
    const sqmap_mujoco_options options = {.size = sizeof options, .is_complete = 1, .max_contacts = max_contacts};
    sqmap_mujoco* override = NULL;
    expect(sqmap_mujoco_install(m, &options, &override) == SQMAP_OK, "the balls are baked");
    mj_resetData(m, d);
    d->qpos[2] = 1.6;
    mj_forward(m, d);
    sqmap_mujoco_remove(override);
    expect(d->ncon >= 1 && d->ncon <= limit, "no more contacts are kept than were asked for");
    double deepest = 0;
    for (int i = 0; i < d->ncon; ++i) deepest = fmax(deepest, -d->contact[i].dist);
    printf("at most %d: %d contacts, depth %.6f\n", limit, d->ncon, deepest);
    return deepest;
}

static void try_balls(const char* path)
{
    FILE* file = fopen(path, "w");
    if (file != NULL) write_balls(file);
    mjModel* m = file != NULL && fclose(file) == 0 ? load(path) : NULL;
    expect(m != NULL, "the balls' file is read");
    if (m == NULL) return;
    mjData* d = mj_makeData(m);
    const double all = depth_of_balls(m, d, 0);
    expect(d->ncon > 10, "the contacts kept are spread over the balls");
    const double few = depth_of_balls(m, d, 7), one = depth_of_balls(m, d, 1);
    expect(fabs(all - 0.4) < 0.02, "the poles are 0.4 deep");
    expect(few == all && one == all, "the deepest contact is kept");
    mj_deleteData(d);
    mj_deleteModel(m);
}

/// How far free bodies go in some seconds: the most that one turns, degrees, slides and sinks, m.
static void simulate(const mjModel* m, double seconds, double limits[3], const char* name)
{
    enum { k_max_coordinates = 64 };
    double before[k_max_coordinates], moved[3] = {0, 0, 0};
    const sqmap_mujoco_options options = {.size = sizeof options, .is_complete = 1};
    sqmap_mujoco* override = NULL;
    expect(sqmap_mujoco_install(m, &options, &override) == SQMAP_OK, "the bodies are baked");
    mjData* d = mj_makeData(m);
    mj_forward(m, d);
    for (int i = 0; i < m->nq; ++i) before[i] = d->qpos[i];
    while (d->time < seconds) mj_step(m, d);
    for (int b = 0; b < m->nq; b += 7) {
        const double *p = before + b, *q = d->qpos + b;
        const double turned = p[3] * q[3] + p[4] * q[4] + p[5] * q[5] + p[6] * q[6];
        moved[0] = fmax(moved[0], 2 * acos(fmin(fabs(turned), 1)) * 180 / k_pi);
        moved[1] = fmax(moved[1], hypot(q[0] - p[0], q[1] - p[1]));
        moved[2] = fmax(moved[2], fabs(p[2] - q[2]));
    }
    printf("%s: turned %.4f degrees, slid %.6f, sank %.6f, %d contacts\n", name, moved[0], moved[1], moved[2], d->ncon);
    for (int k = 0; k < 3; ++k) expect(moved[k] < limits[k], "what stands stays");
    sqmap_mujoco_remove(override);
    mj_deleteData(d);
}

/// Boxes of 0.1 m stand on each other for two seconds, the upper one moved sideways by some amount.
static void try_boxes(const char* path, double x, double y)
{
    FILE* file = fopen(path, "w");
    if (file == NULL) return expect(0, "the boxes' file is written");
    fprintf(file,
            "<mujoco><asset><mesh name='box' vertex='0 0 0 .1 0 0 0 .1 0 .1 .1 0 0 0 .1 .1 0 .1 0 .1 .1 .1 .1 .1'/></asset>"
            "<worldbody><geom type='mesh' mesh='box'/><body pos='%g %g .1'><freejoint/><geom type='mesh' mesh='box'/></body>"
            "</worldbody></mujoco>",
            x, y);
    mjModel* m = fclose(file) == 0 ? load(path) : NULL;
    if (m == NULL) return expect(0, "the boxes' file is read");
    char name[100];
    snprintf(name, sizeof name, "box on a box, moved by %g, %g", x, y);
    simulate(m, 2, (double[]){0.2, 5e-4, 2e-3}, name);
    mj_deleteModel(m);
}

/// Six flat prisms on a seventh, each a little beside the one below and turned by some angle, stand for three seconds.
static void try_tower(const char* path, int sides, double degrees)
{
    FILE* file = fopen(path, "w");
    if (file == NULL) return expect(0, "the tower's file is written");
    fputs("<mujoco><size njmax='4000' nconmax='1000'/><asset><mesh name='m' vertex='", file);
    for (int i = 0; i < 2 * sides; ++i) {
        const double around = k_pi * (i / 2 * 2 + 1) / sides;
        fprintf(file, "%.9g %.9g %g ", .05 * cos(around), .05 * sin(around), i % 2 * .04);
    }
    fputs("'/></asset><worldbody><geom type='mesh' mesh='m'/>", file);
    for (int k = 1; k <= 6; ++k)
        fprintf(file, "<body pos='%g %g %g' euler='0 0 %g'><freejoint/><geom type='mesh' mesh='m'/></body>", .002 * sin(1.7 * k),
                .002 * cos(2.3 * k), .0402 * k, k * degrees);
    fputs("</worldbody></mujoco>", file);
    mjModel* m = fclose(file) == 0 ? load(path) : NULL;
    if (m == NULL) return expect(0, "the tower's file is read");
    char name[100];
    snprintf(name, sizeof name, "tower of prisms of %d sides, turned by %g degrees", sides, degrees);
    simulate(m, 3, (double[]){3, 0.01, 0.01}, name);
    mj_deleteModel(m);
}

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    try_balls(argv[1]);
    const double offsets[] = {0, 1e-6, 1e-4, 0.03};
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k <= i; ++k) try_boxes(argv[1], offsets[i], -offsets[k]);
    const int sides[] = {3, 4, 6, 24};
    for (int i = 0; i < 8; ++i) try_tower(argv[1], sides[i / 2], i % 2 * 10);
    FILE* file = fopen(argv[1], "w");
    if (file == NULL || fputs(xml, file) < 0 || fclose(file) != 0) return 1;
    mjModel* m = load(argv[1]);
    if (m == NULL) return 1;
    mjData* d = mj_makeData(m);
    expect(contacts_at(m, d, 0, 1.9) == 0, "no vertex of crossed bars is in the other one");
    expect(contacts_at(m, d, 1, 2.1) == 0, "bars that are apart have no contact");
    expect(contacts_at(m, d, 1, 1.9) == 1, "crossed ridges have one contact");
    if (d->ncon == 1) {
        const mjContact* c = d->contact;
        expect(fabs(c->dist + 0.1) < 1e-6, "the ridges are 0.1 deep");
        expect(fabs(fabs(c->frame[2]) - 1) < 1e-6, "the normal is upright");
        expect(hypot(c->pos[0], c->pos[1]) < 1e-6 && fabs(c->pos[2] - 0.95) < 1e-6, "the contact is where the ridges cross");
        printf("depth %.9f\n", -c->dist);
    }
    mj_deleteData(d);
    mj_deleteModel(m);
    return failures == 0 ? 0 : 1;
}
