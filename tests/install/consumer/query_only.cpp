// Uses the libraries that a running program needs: a file that is no model must be refused, not loaded.
#include <sqmap/io/model_file.h>
#include <sqmap/sqmap.h>

#include <cstdio>
#include <fstream>

int main()
{
    std::ofstream("not_a_model.sqmap") << "this is no model, and long enough to be looked at";
    try {
        const sqmap::io::MappedModel file("not_a_model.sqmap");
        return static_cast<int>(sqmap::query::query_point(file.view(), {}).contact) + 1;
    } catch (const sqmap::io::ModelFileError& e) {
        std::printf("%s\n", e.what());
    }
    return 0;
}
