// A program in C: opens no model, and is told why.
#include <sqmap.h>

#include <stdio.h>
#include <string.h>

int main(void)
{
    sqmap_model model;
    const sqmap_code code = sqmap_open("not_there.sqmap", &model);
    printf("%s %s: %s\n", sqmap_version(), sqmap_last_error()->name, sqmap_last_error()->message);
    return code == SQMAP_E_FILE && strlen(sqmap_last_error()->cure) > 0 ? 0 : 1;
}
