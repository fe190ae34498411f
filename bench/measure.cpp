// sqmap_measure TOPIC: what the documentation says of cost and exactness, a topic for each page that has figures.
#include "measure.h"

#include <cstdio>
#include <exception>
#include <string_view>

namespace sqmap::bench {
namespace {

struct Topic {
    const char *name, *words, *about;
    int (*run)(int, char**);
    const char* package = "";  ///< what a topic needs that was not compiled in
};

#ifdef SQMAP_MEASURE_FCL
constexpr auto k_contacts = &measure_contacts, k_clearance = &measure_clearance;
#else
constexpr int (*k_contacts)(int, char**) = nullptr, (*k_clearance)(int, char**) = nullptr;
#endif
#ifdef SQMAP_MEASURE_PILE
constexpr auto k_pile = &measure_pile;
#else
constexpr int (*k_pile)(int, char**) = nullptr;
#endif
#ifdef SQMAP_MEASURE_CLOTH
constexpr auto k_cloth = &measure_cloth;
#else
constexpr int (*k_cloth)(int, char**) = nullptr;
#endif
#ifdef SQMAP_MEASURE_DRESSED
constexpr auto k_drape = &measure_drape, k_dressed = &measure_dressed;
#else
constexpr int (*k_drape)(int, char**) = nullptr, (*k_dressed)(int, char**) = nullptr;
#endif
#ifdef SQMAP_MEASURE_CGAL
constexpr auto k_borders = &measure_borders, k_wrap = &measure_wrap, k_invariance = &measure_invariance;
#else
constexpr int (*k_borders)(int, char**) = nullptr, (*k_wrap)(int, char**) = nullptr, (*k_invariance)(int, char**) = nullptr;
#endif

constexpr Topic k_topics[] = {
    {"borders", "MESH...",
     "Borders of parts and of named parts beside the shortest loops of edges within a quarter of their radius.", k_borders,
     "libcgal-dev"},
    {"clearance", "POSES MESH_A MESH_B",
     "Distance of two meshes that are apart, beside FCL's: time and error at 0.1 % of R_max to all of it.", k_clearance,
     "libfcl-dev"},
    {"cloth", "OUT.json VERTICES [--own] [--scene skirt|shirt|blanket] [--shift X Z] [MODEL.off]...",
     "Fig. 11b: cloth against an avatar, beside FCL and dense fields. Models are solids in metres, y up: a blanket falls on "
     "each, from\n"
     "X and Z metres beside its middle. --own: the cloth's own collisions alone.",
     k_cloth, "libfcl-dev libbullet-dev"},
    {"distance", "POINTS PROBE MESH...",
     "Signed distances against the exact oracle, and their time beside Embree's. Meshes are closed.", &measure_distance},
    {"coherence", "MILLIMETRES PATH.csv OBJECT PROBE",
     "Probe queries with a workspace beside those without, the probe moving so many millimetres a tick along a path about an\n"
     "object of 0.3 m: time, and that contacts have the same bits.",
     &measure_coherence},
    {"contacts", "POSES|PATH.csv MESH_A MESH_B",
     "How many contacts of two meshes have no vertex in them, at each depth of pressing; or along a path of MESH_B, the time of\n"
     "complete contacts beside that of vertices and of FCL's pairs of triangles.",
     k_contacts, "libfcl-dev"},
    {"drape", "[--fabric NAME] [--pitch METRES] [--bend N_M]",
     "Drape coefficient of each fabric, beside what was measured on cloth: a disc of 30 cm hangs over one of 18 cm.", k_drape,
     "libbullet-dev"},
    {"dressed", "[--seconds S] [--vertices N] [--garment shirt|poncho|skirt]... [--fabric NAME]...",
     "Skin that is seen where cloth should hide it, and depth of cloth in the body: garments on the walking figure, pulled to 30 "
     "N,\n"
     "seams opened, every tenth frame from four sides. Default: 6 s, 3000 vertices, three garments of three fabrics.",
     k_dressed, "libbullet-dev"},
    {"first-touch", "SAMPLE_QUERIES",
     "First touch of points and triangles, edges and edges, on a clone of\n"
     "github.com/Continuous-Collision-Detection/Sample-Queries: verdicts and time.",
     &measure_first_touch},
    {"haptic", nullptr, "The force: steps while sliding, energy around closed paths, time of a tick, density of a hand's points.",
     &measure_haptic},
    {"invariance", "MESH...",
     "Share of the area on which parts and named parts stay when a mesh is turned, scaled, reflected, or simplified by 30 %.",
     k_invariance, "libcgal-dev"},
    {"joints", "HAND.glb PICTURE.png [--layer 2|3|exact] [--solids LEAST_WEIGHT] [--azimuth DEGREES] [--elevation DEGREES]",
     "Where on a skinned hand the verdicts are wrong: a picture, and a table of the joints.", &measure_joints},
    {"pile", "BODIES THREADS MESH...",
     "All contacts of a pile of bodies at given poses, beside FCL and Bullet's GImpact with as many threads. Meshes are closed.",
     k_pile, "libfcl-dev libbullet-dev"},
    {"poses", "POSES MESH...",
     "Poses of a gripper of 500 points answered in one call, beside every point by itself. Meshes are closed.", &measure_poses},
    {"rebake", "[--move SHARE] [--quick] MESH...",
     "What it costs to bake each part anew that bends by SHARE of R_max (0.01), on one core. --quick: the result is not checked.",
     &measure_rebake},
    {"scene-cost", "far|pile|probe BODIES FRAMES",
     "What a scene does in a frame, to be counted by callgrind; with 0 FRAMES the set-up alone. At most 5000 bodies.",
     &measure_scene_cost},
    {"segmentation", "FOLDER [--sheet PICTURE.png] [--labels FOLDER] [--cuts printed]",
     "Rand index error of parts and of named parts against people's, per class. FOLDER holds models/N.off and "
     "humans/N_K.seg.gz of\n"
     "the Princeton benchmark. --sheet: each model's parts, named parts and a person's. --labels: N.csv, part and name a face. "
     "--cuts printed: of\n"
     "section 3's cuts as printed, before any other.",
     &measure_segmentation},
    {"skin", "HAND.glb OBJECT [--cell SHARE] [--layer 2|3|exact] [--solids LEAST_WEIGHT] [--worst FILE.csv]",
     "Contacts of a skinned model against the exact skinned mesh, and against rigid solids, one a joint.", &measure_skin},
    {"wrap", "[--alpha SHARE] [--offset SHARE] MESH...",
     "Wrapping beside CGAL's alpha wrap. SHAREs of R_max, default 0.01 and 0.002.", k_wrap, "libcgal-dev"},
};

void print_topics(std::FILE* out)
{
    std::fputs("Usage: sqmap_measure TOPIC ...     sqmap_measure TOPIC --help says more\n", out);
    for (const Topic& topic : k_topics) std::fprintf(out, "  %-12s %s\n", topic.name, topic.about);
    std::fputs("Exit code: 0 done, 2 bad input, 64 wrong usage, 69 the topic's package was missing when this was built.\n", out);
}

void print_usage(std::FILE* out, const Topic& topic)
{
    std::fprintf(out, "Usage: sqmap_measure %s %s\n%s\n", topic.name, topic.words, topic.about);
}

int run(const Topic& topic, int argc, char** argv)
{
    if (topic.words != nullptr && argc > 1 && std::string_view(argv[1]) == "--help") {
        print_usage(stdout, topic);
        return 0;
    }
    if (topic.run == nullptr) {
        std::fprintf(stderr, "sqmap_measure %s: not compiled in\n  cure: install %s, configure and build again\n", topic.name,
                     topic.package);
        return 69;
    }
    const int code = topic.run(argc, argv);
    if (code == k_wrong_usage && topic.words != nullptr) print_usage(stderr, topic);
    return code;
}

}  // namespace
}  // namespace sqmap::bench

int main(int argc, char** argv)
{
    const std::string_view name = argc > 1 ? argv[1] : "";
    for (const sqmap::bench::Topic& topic : sqmap::bench::k_topics) {
        if (name != topic.name) continue;
        try {
            return sqmap::bench::run(topic, argc - 1, argv + 1);
        } catch (const std::exception& e) {
            std::fprintf(stderr, "sqmap_measure %s: %s\n", topic.name, e.what());
            return 2;
        }
    }
    const bool help = name == "--help" || name == "-h";
    sqmap::bench::print_topics(help ? stdout : stderr);
    return help ? 0 : sqmap::bench::k_wrong_usage;
}
