// Signed distances to a baked model, inside and outside: how far, where the nearest surface is, and how that is known.
#include <sqmap/io/model_file.h>
#include <sqmap/sqmap.h>

#include <cstdio>

int main(int argc, char** argv)
try {
    if (argc != 2) return 64;
    const sqmap::io::MappedModel file(argv[1]);
    for (const double height : {0.95, 1.05, 3.0}) {
        // Distances are exact everywhere by default, and exact_distance() has them in double. In real time, beyond the band that
        // the model was baked with (5 % of its size), a lower bound suffices to rule a contact out.
        const auto d = sqmap::query::distance(file.view(), {0, 0, height}, sqmap::query::k_baked_band);
        const bool exact = d.known == sqmap::query::DistanceKind::Exact;
        std::printf("%s %.2f\n", exact ? "exactly" : "at least", d.distance);
    }
} catch (const sqmap::io::ModelFileError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 65;
}
