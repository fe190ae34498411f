#include "sqmap/query/point.h"

#include "commands.h"
#include "common/layer_name.h"
#include "common/program_words.h"
#include "io/replace_file.h"
#include "parallel/for_each.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/model.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/distance.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sqmap::app {
namespace {

/// A points file that does not read as x,y,z rows.
class BadPoints : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

bool parse_row(std::string_view line, double v[3])
{
    for (int i = 0; i < 3; ++i) {
        while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), v[i]);
        if (error != std::errc()) return false;
        line.remove_prefix(static_cast<std::size_t>(end - line.data()));
        while (!line.empty() && (line.front() == ' ' || line.front() == '\t' || line.front() == '\r')) line.remove_prefix(1);
        if (i < 2) {
            if (line.empty() || line.front() != ',') return false;
            line.remove_prefix(1);
        }
    }
    return line.empty();
}

std::vector<Vec3d> read_points(const std::string& path)
{
    std::ifstream in(path);
    if (!in) throw BadPoints("cannot open " + path);
    const auto fail = [&](std::size_t number, const std::string& message) {
        throw BadPoints(path + ":" + std::to_string(number) + ": " + message);
    };
    std::string line;
    std::size_t number = 0, blank = 0;  // blank: the first of the blank lines just read
    bool has_header = false;
    std::vector<Vec3d> points;
    while (std::getline(in, line)) {
        if (++number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // spreadsheets mark UTF-8
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.pop_back();
        if (line.empty()) {
            if (blank == 0) blank = number;
            continue;
        }
        if (!has_header) {
            if (line != "x,y,z") fail(number, "the header must be x,y,z, found '" + line.substr(0, 40) + "'");
            has_header = true;
            blank = 0;
            continue;
        }
        // Answers stand in the order of the rows: a blank line among them may be a point that was lost.
        if (blank != 0) fail(blank, "expected three numbers x,y,z, found a blank line");
        double v[3];
        if (!parse_row(line, v)) fail(number, "expected three numbers x,y,z, found '" + line.substr(0, 60) + "'");
        points.push_back({v[0], v[1], v[2]});
    }
    if (!has_header) throw BadPoints(path + " is empty: its first line must be the header x,y,z");
    return points;
}

/// Digits that show a coordinate as finely as nine digits show the object's size: more of them far from the origin.
int digits_of(double coordinate, double size)
{
    const double beyond = std::floor(std::log10(std::abs(coordinate))) - std::floor(std::log10(size));
    return 9 + static_cast<int>(std::clamp(beyond, 0.0, 8.0));  // 17 tell any two doubles apart; of 0 beyond is -inf
}

struct QueryArguments {
    std::string model, points, output, layer = "3", projector = "newton";
    double tolerance = -1;  ///< mesh units; not given: auto is the gate
    std::uint32_t gate = query::k_gate;
    int nearest_steps = 2;
    bool certain = false, status = false, offset = false, smoothed_map = false, no_gaps = false, no_pruning = false;
    bool distance = false;
    double band = query::k_baked_band;  ///< mesh units
};

paper::Projector projector_named(const std::string& name)
{
    return name == "pyramid" ? paper::Projector::Pyramid
                             : (name == "printed" ? paper::Projector::Printed : paper::Projector::Newton);
}

paper::QueryOptions paper_options(const QueryArguments& o)
{
    return {projector_named(o.projector), o.nearest_steps, !o.no_gaps, !o.no_pruning};
}

/// A row for each point, in their order.
std::string answers(const model::ModelView& m, const std::vector<Vec3d>& points, const QueryArguments& o)
{
    const bool by_gate = o.layer == "auto" && o.tolerance < 0;
    const query::Layer without_tolerance =
        model::is_doubtful(m.measured) && model::has_exact(m) ? query::Layer::Exact : query::Layer::Gate;
    const query::QueryOptions options{.layer = by_gate ? without_tolerance : layer_named(o.layer).value(),
                                      .tolerance = o.tolerance,
                                      .gate = o.gate,
                                      .offset = o.offset,
                                      .smoothed_map = o.smoothed_map};
    if (options.layer == query::Layer::Exact && !model::has_exact(m))
        throw BadPoints(o.model + " was baked without the exact layer: bake it with --exact");
    if (options.layer == query::Layer::Auto && query::query_point(m, {}, options).status == query::k_no_exact)
        std::fprintf(stderr, "%s: no layer is within %g, and it was baked without the exact layer: layer 3 answers\n",
                     o.model.c_str(), o.tolerance);
    query::QueryOptions chosen = options;
    chosen.layer = query::chosen_layer(m, options);
    if (const auto idle = paper::idle_option(paper_options(o), paper::is_paper(m), chosen))
        throw BadPoints(o.model + ": " + option_of(*idle) + " " + reason_of(*idle));
    if (options.smoothed_map && !paper::has_smoothed_map(m))
        throw BadPoints(o.model + " has no smoothed map: bake it with --smoothing-radius 1 or more");
    const double size = m.header.r_max * m.header.unit;
    std::string text;
    char row[256];
    const auto print = [&](const char* format, auto... values) {
        text.append(row, static_cast<std::size_t>(std::snprintf(row, sizeof row, format, values...)));
    };
    print("contact,part,depth,nx,ny,nz,px,py,pz%s\n",
          (std::string(o.certain ? ",certain" : "") + (o.status ? ",status" : "")).c_str());
    for (const Vec3d& p : points) {
        const query::PointResult c = query::query_point(m, p, options);
        if (c.contact)
            print("1,%d,%.9g,%.9g,%.9g,%.9g,%.*g,%.*g,%.*g", c.part, c.depth, c.normal.x, c.normal.y, c.normal.z,
                  digits_of(c.witness.x, size), c.witness.x, digits_of(c.witness.y, size), c.witness.y,
                  digits_of(c.witness.z, size), c.witness.z);
        else
            text += "0,-1,,,,,,,";
        if (o.certain) print(",%d", c.certain ? 1 : 0);
        if (o.status) print(",%u", static_cast<unsigned>(c.status));
        text += '\n';
    }
    return text;
}

/// The same for signed distances.
std::string distances(const model::ModelView& m, const std::vector<Vec3d>& points, const QueryArguments& o)
{
    if (paper::is_paper(m) && !model::has_distance(m))
        throw BadPoints(o.model + " is a paper model without triangles, so it has no distances: bake it with --exact");
    constexpr std::size_t k_slice = 16384;
    std::vector<query::SignedDistance> answers(points.size());
    parallel::for_slices(points.size(), k_slice, 0, [&](parallel::Slice slice) {
        query::distances(m, std::span(points).subspan(slice.first, slice.count),
                         std::span(answers).subspan(slice.first, slice.count), o.band);
    });
    const double size = m.header.r_max * m.header.unit;
    std::string text = "distance,known,part,gx,gy,gz,px,py,pz\n";
    char row[256];
    for (const query::SignedDistance& a : answers) {
        if ((a.status & query::k_not_finite) != 0) {
            text += ",none,-1,,,,,,\n";
            continue;
        }
        const bool bound = a.known == query::DistanceKind::LowerBound;
        const char* const known = bound ? "bound" : a.known == query::DistanceKind::Exact ? "exact" : "approximate";
        int length = std::snprintf(row, sizeof row, "%.9g,%s,%d,", a.distance, known, a.part);
        text.append(row, static_cast<std::size_t>(length));
        if (bound) {
            text += ",,,,,\n";
            continue;
        }
        length = std::snprintf(row, sizeof row, "%.9g,%.9g,%.9g,%.*g,%.*g,%.*g\n", a.gradient.x, a.gradient.y, a.gradient.z,
                               digits_of(a.witness.x, size), a.witness.x, digits_of(a.witness.y, size), a.witness.y,
                               digits_of(a.witness.z, size), a.witness.z);
        text.append(row, static_cast<std::size_t>(length));
    }
    return text;
}

int run(const QueryArguments& o)
{
    if (o.tolerance >= 0 && o.layer != "auto") {
        std::fprintf(stderr, "--tolerance is read by --layer auto alone\n");
        return 64;
    }
    io::check_output(o.output, {o.model, o.points});
    paper::MappedModel file(o.model);
    file.set_options(paper_options(o));
    const std::vector<Vec3d> points = read_points(o.points);
    const std::string text = o.distance ? distances(file.view(), points, o) : answers(file.view(), points, o);
    io::replace_file(o.output, std::as_bytes(std::span(text)));
    return 0;
}

}  // namespace

void add_query(CommandLine& line)
{
    const auto options = std::make_shared<QueryArguments>();
    Command command = line.add("query", "Query a model at points: inside, penetration depth, normal");
    command.option("model", options->model, "Model (.sqmap)").required().existing_file();
    command.option("points", options->points, "CSV with the header x,y,z; mesh units").required().existing_file();
    command.option("-o,--output", options->output, "CSV to write, a row for each row of points").required();
    Option layer =
        command
            .option(
                "--layer", options->layer,
                "1 superquadrics; 2 and 3 the locator's planes, coarse and fine, or of a paper model the map's base and finest "
                "samples; exact: triangles; gate: 2 or 3 by k_L; auto: the cheapest within --tolerance, or without one as "
                "gate; exact where layer 3 is in doubt")
            .one_of({"1", "2", "3", "exact", "auto", "gate"});
    Option gate = command
                      .option("--gate", options->gate,
                              "k_L: gate reads layer 3 for a part with fewer base samples than this times its vertices")
                      .in_range(0, 4294967295.);
    Option tolerance = command.option("--tolerance", options->tolerance, "Depth error that auto may make, mesh units")
                           .not_below_zero()
                           .shows_default("");
    Option certain = command.flag("--certain", options->certain, "Add a column: 1 where the verdict is proven");
    Option status = command.flag(
        "--status", options->status,
        "Add a column, a sum of: 1 the point is not finite, 2 no exact layer (layer 3 answered), 4 inside but no map "
        "shows the surface (no depth, no normal), 16 the surface there was made up by a cure, 128 an option that "
        "the model's projection does not give");
    Option offset = command.flag("--offset", options->offset,
                                 "Move the surface out by the stored offset, for probes made of triangles (eq. 12)");
    Option smoothing = command.flag("--smooth", options->smoothed_map, "Depth and normal of the smoothed map, for force");
    Option projector = command
                           .option("--projector", options->projector,
                                   "Foot search of a paper model's layers 2 and 3: newton, pyramid (eqs. 16 to 19, corrected), "
                                   "printed (to the letter)")
                           .one_of({"newton", "pyramid", "printed"});
    Option steps = command
                       .option("--nearest-steps", options->nearest_steps,
                               "Steps to the nearest surface after the foot of a paper model's layer 3 (newton); 0: depth to the "
                               "tangent plane on the foot's line")
                       .in_range(option_named(paper::k_query_numbers, "nearest_steps").range);
    Option gaps = command.flag("--no-gaps", options->no_gaps, "A paper model's first surfaces alone, as the paper has them");
    Option pruning =
        command.flag("--no-pruning", options->no_pruning, "Paper models: contact where any part claims it (section 2)");
    Option distance =
        command.flag("--distance", options->distance, "Signed distances on both sides instead, exact within the model's band");
    for (Option other : {layer, gate, tolerance, certain, status, offset, smoothing, projector, steps, gaps, pruning})
        distance.excludes(other);
    command.option("--band", options->band, "How far distances are to be exact, mesh units; not given: as baked")
        .not_below_zero()
        .shows_default("")
        .needs(distance);
    command.footer(
        "Columns: contact,part,depth,nx,ny,nz,px,py,pz: depth and point in mesh units, normal outward; 9 digits, more of a "
        "point far from the origin.\n"
        "With --distance: distance,known,part,gx,gy,gz,px,py,pz: negative inside, gradient, nearest surface point; known is "
        "exact, approximate, bound: no farther than the truth and at least half of it, or none: a point that is not finite.\n"
        "Exit code: 0 written, 2 bad model or points, 64 wrong usage, 70 internal error.");
    command.run<BadPoints, io::ModelFileError>([options] { return run(*options); });
}

}  // namespace sqmap::app
