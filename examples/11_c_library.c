// The same from C: bake arrays, query points, press a tool into the model, with every error said in words.
#include <sqmap.h>

#include <stdio.h>

static int failed(const char* call)
{
    const sqmap_error* e = sqmap_last_error();
    fprintf(stderr, "%s: %s at %s: %s\n  cure: %s\n", call, e->name, e->element, e->message, e->cure);
    return 65;
}

int main(void)
{
    // A cube of side 2. Structs: size, then what is not the default.
    const double vertices[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                   {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
    const int64_t triangles[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    const sqmap_mesh cube = {
        .size = sizeof cube, .vertices = vertices[0], .vertex_count = 8, .triangles = triangles[0], .triangle_count = 12};
    sqmap_model model;
    if (sqmap_bake(&cube, NULL, &model) != SQMAP_OK) return failed("sqmap_bake");

    // Signed distances on both sides. No allocation, no lock.
    const double xyz[2][3] = {{0, 0, 0.9}, {0, 0, 1.05}};
    double distance[2];
    const sqmap_points points = {.size = sizeof points, .xyz = xyz[0], .count = 2};
    sqmap_distances answers = {.size = sizeof answers, .distance = distance};
    if (sqmap_signed_distances(model, &points, NULL, &answers) != SQMAP_OK) return failed("sqmap_signed_distances");
    printf("%.2f and %.2f from the surface\n", distance[0], distance[1]);

    // A stylus as a hand drives it, 1 kHz: a second above a cube of 10 cm, then 3 mm into it.
    static double targets[4000][3], forces[4000][3];
    for (int tick = 0; tick < 4000; ++tick)
        targets[tick][2] = tick < 1000 ? 0.060 : tick < 3000 ? 0.060 - 0.013 * (tick - 1000) / 2000 : 0.047;
    const sqmap_session_options options = {
        .size = sizeof options, .metres_per_unit = 0.05, .max_force = 3, .continuous_force = 1};
    const sqmap_simulation run = {.size = sizeof run, .targets = targets[0], .count = 4000, .forces = forces[0]};
    sqmap_session session;
    if (sqmap_make_session(model, &options, &session) != SQMAP_OK) return failed("sqmap_make_session");
    sqmap_close_model(model);  // the session keeps what it needs
    if (sqmap_simulate(session, &run) != SQMAP_OK) return failed("sqmap_simulate");
    printf("%.1f N above, %.1f N pressed\n", forces[500][2], forces[3999][2]);

    sqmap_close_session(session);
    if (sqmap_signed_distances(model, &points, NULL, &answers) == SQMAP_E_HANDLE) printf("%s\n", sqmap_last_error()->message);
    return 0;
}
