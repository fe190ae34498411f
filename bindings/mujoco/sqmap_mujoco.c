#include "sqmap_mujoco.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { k_first_capacity = 64 };

typedef struct Mesh {
    sqmap_model model;
    sqmap_probe probe;
} Mesh;

struct sqmap_mujoco {
    const mjModel* model;
    Mesh* meshes;  ///< by mesh number; {0} where sqmap does not answer
    int32_t layer;
    int max_contacts;
    int is_complete;
    sqmap_mujoco* next;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static sqmap_mujoco* installed;
static mjfCollision hulls;  ///< MuJoCo's own function
static _Thread_local sqmap_workspace workspace;

static const sqmap_mujoco* override_of(const mjModel* m)
{
    const sqmap_mujoco* o = installed;
    while (o != NULL && o->model != m) o = o->next;
    return o;
}

static sqmap_pose pose_of(const mjData* d, int geom)
{
    sqmap_pose pose;
    for (int i = 0; i < 9; ++i) pose.rotation[i] = d->geom_xmat[9 * geom + i];
    for (int i = 0; i < 3; ++i) pose.translation[i] = d->geom_xpos[3 * geom + i];
    return pose;
}

static double distance_sq(const double* a, const double* b)
{
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

/// A contact of either query.
typedef struct Found {
    double on_a[3], on_b[3];
    float normal[3], depth;
    int order;  ///< in the query's answer, so that equal depths are told apart
} Found;

static _Thread_local Found* found;
static _Thread_local size_t capacity;  ///< of `found` and of the workspace

static int is_deeper(const void* a, const void* b)
{
    const Found *p = a, *q = b;
    if (p->depth != q->depth) return p->depth < q->depth ? 1 : -1;
    return p->order - q->order;
}

/// Keeps at most `limit` of the contacts, deepest first: one of those that are close to one another and point the same way. The
/// distance that counts as close grows until they are few enough, and once it is that of all of them, so does the angle.
static int thinned(Found* contacts, int count, int limit)
{
    qsort(contacts, (size_t)count, sizeof *contacts, is_deeper);
    if (count <= limit) return count;
    double lo[3], hi[3];
    for (int k = 0; k < 3; ++k) lo[k] = hi[k] = contacts[0].on_a[k];
    for (int i = 1; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            lo[k] = fmin(lo[k], contacts[i].on_a[k]);
            hi[k] = fmax(hi[k], contacts[i].on_a[k]);
        }
    const double extent = sqrt(distance_sq(lo, hi));
    float alike = 0.9f;  // cosine
    for (double close = 0.02 * extent;; close *= 1.5) {
        if (close > extent) alike -= 0.2f;
        Found kept[mjMAXCONPAIR];
        int n = 0;
        for (int i = 0; i < count && n <= limit; ++i) {
            int is_new = 1;
            for (int j = 0; j < n && is_new; ++j) {
                const float* a = contacts[i].normal;
                const float* b = kept[j].normal;
                is_new = distance_sq(contacts[i].on_a, kept[j].on_a) > close * close ||
                         a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < alike;
            }
            if (is_new && n == limit) ++n;  // too many
            if (is_new && n < limit) kept[n++] = contacts[i];
        }
        if (n <= limit || !(close > 0)) {
            const int written = n < limit ? n : limit;
            memcpy(contacts, kept, (size_t)written * sizeof *kept);
            return written;
        }
    }
}

/// False where there is no memory.
static int has_memory(size_t contacts)
{
    if (contacts <= capacity) return 1;
    sqmap_workspace larger = {0};
    Found* space = realloc(found, contacts * sizeof *space);
    if (space != NULL) found = space;
    if (space == NULL || sqmap_make_workspace(contacts, &larger) != SQMAP_OK) return 0;
    sqmap_close_workspace(workspace);
    workspace = larger;
    capacity = contacts;
    return 1;
}

/// 0: all contacts of a query are there; 1: there is space for more now, query again; -1: there is no memory.
static int lacks_space(size_t count, uint32_t status)
{
    if (count <= capacity && (status & SQMAP_FULL) == 0) return 0;
    return has_memory(4 * (count > capacity ? count : capacity)) ? 1 : -1;
}

static int add_found(int count, const double* on_a, const double* on_b, const float* normal, float depth)
{
    Found* f = found + count;
    memcpy(f->on_a, on_a, sizeof f->on_a);
    memcpy(f->on_b, on_b, sizeof f->on_b);
    memcpy(f->normal, normal, sizeof f->normal);
    f->depth = depth;
    f->order = count;
    return count + 1;
}

/// Contacts of vertices, edges and faces; -1 where a mesh is not closed, or without memory.
static int find_complete(const sqmap_bodies* bodies)
{
    sqmap_surface_list list = {.size = sizeof list};
    int lacks = 1;
    while (lacks == 1) {
        if (sqmap_query_contacts(bodies, NULL, workspace, &list) != SQMAP_OK) return -1;
        lacks = lacks_space(list.count, list.status);
    }
    if (lacks < 0) return -1;
    int count = 0;
    for (size_t i = 0; i < list.count; ++i) {
        const sqmap_surface_contact* c = list.contacts + i;
        count = add_found(count, c->on_a, c->on_b, c->normal, c->depth);
    }
    return count;
}

/// Contacts of vertices; -1 where the query fails.
static int find_vertices(const sqmap_bodies* bodies, int32_t layer, double margin)
{
    const sqmap_query_options options = {.size = sizeof options, .layer = layer, .margin = margin};
    sqmap_pair_list list = {.size = sizeof list};
    int lacks = 1;
    while (lacks == 1) {
        if (sqmap_query_pair(bodies, &options, workspace, &list) != SQMAP_OK) return -1;
        lacks = lacks_space(list.count, list.status);
    }
    if (lacks < 0) return -1;
    int count = 0;
    for (size_t i = 0; i < list.count; ++i) {
        const sqmap_pair_contact* c = list.contacts + i;
        count = add_found(count, c->on_a, c->on_b, c->normal, c->depth);
    }
    return count;
}

static int collide(const mjModel* m, const mjData* d, mjContact* con, int g1, int g2, mjtNum margin)
{
    const sqmap_mujoco* o = override_of(m);
    const int a = m->geom_dataid[g1], b = m->geom_dataid[g2];
    if (o == NULL || o->meshes[a].model.id == 0 || o->meshes[b].model.id == 0) return hulls(m, d, con, g1, g2, margin);
    // MuJoCo's own hulls answer if sqmap fails: a failure must not read as free.
    if (!has_memory(k_first_capacity)) return hulls(m, d, con, g1, g2, margin);
    const sqmap_pose pa = pose_of(d, g1), pb = pose_of(d, g2);
    const sqmap_bodies bodies = {
        sizeof bodies, {o->meshes[a].model, o->meshes[a].probe, &pa}, {o->meshes[b].model, o->meshes[b].probe, &pb}};
    double outwards = 0;  // how far the surfaces of the contacts are moved out
    int count = o->is_complete ? find_complete(&bodies) : -1;
    if (count < 0) {
        outwards = fmax(margin, 0);
        count = find_vertices(&bodies, o->layer, outwards);
    }
    if (count < 0) return hulls(m, d, con, g1, g2, margin);
    count = thinned(found, count, o->max_contacts);
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            con[i].pos[k] = 0.5 * (found[i].on_a[k] + found[i].on_b[k]);
            con[i].frame[k] = found[i].normal[k];
            con[i].frame[3 + k] = 0;
        }
        con[i].dist = outwards - found[i].depth;
    }
    return count;
}

/// A model file of a mesh in a folder, named after its arrays.
static void name_file(char* path, size_t size, const char* folder, const sqmap_mesh* mesh)
{
    uint64_t h = 14695981039346656037ULL;
    const unsigned char* parts[2] = {(const unsigned char*)mesh->vertices, (const unsigned char*)mesh->triangles};
    const size_t bytes[2] = {24 * mesh->vertex_count, 24 * mesh->triangle_count};
    for (int p = 0; p < 2; ++p)
        for (size_t i = 0; i < bytes[p]; ++i) h = (h ^ parts[p][i]) * 1099511628211ULL;
    snprintf(path, size, "%s/%016llx-%u.sqmap", folder, (unsigned long long)h, (unsigned)sqmap_format_version());
}

static sqmap_code bake(const mjModel* m, int mesh, const sqmap_mujoco_options* wanted, Mesh* out)
{
    const char* folder = wanted != NULL ? wanted->folder : NULL;
    const int vertices = m->mesh_vertnum[mesh], faces = m->mesh_facenum[mesh];
    double* xyz = malloc(sizeof(double) * 3 * (size_t)vertices);
    int64_t* corners = malloc(sizeof(int64_t) * 3 * (size_t)faces);
    for (int i = 0; i < 3 * vertices; ++i) xyz[i] = m->mesh_vert[3 * m->mesh_vertadr[mesh] + i];
    for (int i = 0; i < 3 * faces; ++i) corners[i] = m->mesh_face[3 * m->mesh_faceadr[mesh] + i];
    const sqmap_mesh triangles = {sizeof triangles, xyz, (size_t)vertices, corners, (size_t)faces};
    char path[4096] = "";
    if (folder != NULL) name_file(path, sizeof path, folder, &triangles);
    sqmap_code code = folder != NULL ? sqmap_open(path, &out->model) : SQMAP_E_FILE;
    if (code != SQMAP_OK) {
        const sqmap_bake_options options = {.size = sizeof options, .source = m->names + m->name_meshadr[mesh]};
        code = sqmap_bake(&triangles, &options, &out->model);
        if (code == SQMAP_OK && folder != NULL) sqmap_save(out->model, path);  // without it the next run bakes again
    }
    const sqmap_points points = {sizeof points, xyz, (size_t)vertices, NULL};
    const int is_complete = wanted != NULL && wanted->is_complete != 0;
    // Open meshes have contacts of vertices alone.
    if (code == SQMAP_OK && !(is_complete && sqmap_make_solid_probe(&triangles, &out->probe) == SQMAP_OK))
        code = sqmap_make_probe(&points, &out->probe);
    free(xyz);
    free(corners);
    return code;
}

static void free_meshes(sqmap_mujoco* o)
{
    for (int i = 0; i < o->model->nmesh; ++i) {
        sqmap_close_model(o->meshes[i].model);
        sqmap_close_probe(o->meshes[i].probe);
    }
    free(o->meshes);
    free(o);
}

sqmap_code sqmap_mujoco_install(const mjModel* model, const sqmap_mujoco_options* options, sqmap_mujoco** override)
{
    if (model == NULL || override == NULL || (options != NULL && options->size != sizeof *options)) return SQMAP_E_ARGUMENT;
    *override = NULL;
    sqmap_mujoco* o = calloc(1, sizeof *o);
    o->model = model;
    o->meshes = calloc((size_t)model->nmesh + 1, sizeof *o->meshes);
    o->layer = options != NULL && options->layer != 0 ? options->layer : SQMAP_LAYER_EXACT;
    o->max_contacts = options != NULL && options->max_contacts > 0 && options->max_contacts < mjMAXCONPAIR ? options->max_contacts
                                                                                                           : mjMAXCONPAIR;
    o->is_complete = options != NULL && options->is_complete != 0;
    sqmap_code first = SQMAP_OK;
    int refused = 0;
    for (int g = 0; g < model->ngeom; ++g) {
        const int mesh = model->geom_dataid[g];
        if (model->geom_type[g] != mjGEOM_MESH || (model->geom_contype[g] == 0 && model->geom_conaffinity[g] == 0) ||
            o->meshes[mesh].model.id != 0)
            continue;
        const sqmap_code code = bake(model, mesh, options, &o->meshes[mesh]);
        if (code == SQMAP_OK) continue;
        ++refused;
        if (first == SQMAP_OK) first = code;
    }
    if (refused > 0 && sqmap_mujoco_meshes(o) == 0) {
        free_meshes(o);
        return first;
    }
    pthread_mutex_lock(&lock);
    if (installed == NULL) {
        hulls = mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH];
        mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH] = collide;
    }
    o->next = installed;
    installed = o;
    pthread_mutex_unlock(&lock);
    *override = o;
    return SQMAP_OK;
}

int sqmap_mujoco_meshes(const sqmap_mujoco* override)
{
    int count = 0;
    for (int i = 0; i < override->model->nmesh; ++i) count += override->meshes[i].model.id != 0;
    return count;
}

void sqmap_mujoco_remove(sqmap_mujoco* override)
{
    if (override == NULL) return;
    pthread_mutex_lock(&lock);
    sqmap_mujoco** at = &installed;
    while (*at != NULL && *at != override) at = &(*at)->next;
    if (*at != NULL) *at = override->next;
    if (installed == NULL) mjCOLLISIONFUNC[mjGEOM_MESH][mjGEOM_MESH] = hulls;
    pthread_mutex_unlock(&lock);
    free_meshes(override);
}
