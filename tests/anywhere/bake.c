// Bakes a mesh file into a model file.
// usage: bake MESH MODEL [normal]
#include <sqmap.h>

#include <stdio.h>
#include <string.h>

static int fail(void)
{
    const sqmap_error* e = sqmap_last_error();
    fprintf(stderr, "%s: %s %s; %s\n", e->name, e->element, e->message, e->cure);
    return 1;
}

int main(int argc, char** argv)
{
    if (argc < 3) return 64;
    sqmap_model model;
    const sqmap_bake_options options = {
        .size = sizeof options, .threads = 1, .projection = argc > 3 && strcmp(argv[3], "normal") == 0};
    if (sqmap_bake_file(argv[1], &options, &model) != SQMAP_OK || sqmap_save(model, argv[2]) != SQMAP_OK) return fail();
    return sqmap_close_model(model) == SQMAP_OK ? 0 : fail();
}
