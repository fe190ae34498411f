// Two bars in MuJoCo whose ridges cross between their vertices: contacts of vertices have none, complete ones the depth.
#include "sqmap_mujoco.h"

#include <math.h>
#include <stdio.h>

static const char* xml =
    "<mujoco><asset>"
    "<mesh name='x' vertex='-3 0 -1 -3 1 0 -3 0 1 -3 -1 0 3 0 -1 3 1 0 3 0 1 3 -1 0'/>"
    "<mesh name='y' vertex='0 -3 -1 1 -3 0 0 -3 1 -1 -3 0 0 3 -1 1 3 0 0 3 1 -1 3 0'/>"
    "</asset><worldbody><geom type='mesh' mesh='x'/>"
    "<body name='upper'><freejoint/><geom type='mesh' mesh='y'/></body></worldbody></mujoco>";

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

int main(int argc, char** argv)
{
    if (argc != 2) return 64;
    FILE* file = fopen(argv[1], "w");
    if (file == NULL || fputs(xml, file) < 0 || fclose(file) != 0) return 1;
    char why[1000] = "";
    mjModel* m = mj_loadXML(argv[1], NULL, why, sizeof why);
    if (m == NULL) {
        fprintf(stderr, "%s\n", why);
        return 1;
    }
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
