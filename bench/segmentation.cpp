// Parts against people's: the Rand index error of fine and of named parts on models of the Princeton segmentation benchmark
// (X. Chen, A. Golovinskiy, T. Funkhouser, A benchmark for 3D mesh segmentation, SIGGRAPH 2009), and a sheet of pictures.
#include "common/polygon_labels.h"
#include "common/render/raycast.h"
#include "measure.h"

#include "decompose/locales.h"
#include "io/replace_file.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/io/read.h"
#include "sqmap/model/named_parts.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace sqmap;
using Labels = std::vector<std::int32_t>;  ///< #polygons of a file

/// Models 20 k + 1 to 20 k + 20 are of class k.
constexpr std::array<const char*, 20> k_classes{"human",     "cup",   "glasses", "airplane", "ant",  "chair",      "octopus",
                                                "table",     "teddy", "hand",    "plier",    "fish", "bird",       "",
                                                "armadillo", "bust",  "mech",    "bearing",  "vase", "four-legged"};

constexpr std::size_t k_max_people = 100;

struct Options {
    std::filesystem::path folder, sheet, labels;
    bool printed = false;  ///< cuts of section 3 as printed, and none after them
};

Options parsed(int argc, char** argv)
{
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--sheet" && i + 1 < argc)
            o.sheet = argv[++i];
        else if (word == "--labels" && i + 1 < argc)
            o.labels = argv[++i];
        else if (word == "--cuts" && i + 1 < argc && std::string(argv[i + 1]) == "printed") {
            o.printed = true;
            ++i;
        } else if (word.empty() || word.front() == '-' || !o.folder.empty())
            return {};
        else
            o.folder = word;
    }
    return o;
}

/// A person's labels. @throw std::runtime_error for a file that has not one number a line, a line a polygon
Labels read_labels(const std::filesystem::path& path, std::size_t polygon_count)
{
    gzFile file = gzopen(path.c_str(), "rb");
    if (file == nullptr) throw std::runtime_error(path.string() + " cannot be opened");
    Labels labels;
    std::array<char, 64> line{};
    std::string bad;
    while (bad.empty() && gzgets(file, line.data(), static_cast<int>(line.size())) != nullptr) {
        char* end = nullptr;
        const long label = std::strtol(line.data(), &end, 10);
        if (end == line.data() || (*end != '\n' && *end != '\r' && *end != '\0'))
            bad = "line " + std::to_string(labels.size() + 1) + " is no part number";
        labels.push_back(static_cast<std::int32_t>(label));
    }
    gzclose(file);
    if (bad.empty() && labels.size() != polygon_count)
        bad = "it has " + std::to_string(labels.size()) + " labels, the model " + std::to_string(polygon_count) + " faces";
    if (!bad.empty()) throw std::runtime_error(path.string() + ": " + bad);
    return labels;
}

/// One minus the share of pairs of different polygons on which both agree: together in both, or apart in both.
double rand_index_error(const Labels& a, const Labels& b)
{
    const auto pairs = [](double n) { return n * (n - 1) / 2; };
    std::map<std::int32_t, double> of_a, of_b;
    std::map<std::pair<std::int32_t, std::int32_t>, double> of_both;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ++of_a[a[i]];
        ++of_b[b[i]];
        ++of_both[{a[i], b[i]}];
    }
    double apart = 0;
    for (const auto& [label, n] : of_a) apart += pairs(n);
    for (const auto& [label, n] : of_b) apart += pairs(n);
    for (const auto& [labels, n] : of_both) apart -= 2 * pairs(n);
    return a.size() < 2 ? 0 : apart / pairs(static_cast<double>(a.size()));
}

/// One model: what bake and what people made of it.
struct Model {
    std::size_t number = 0;
    io::PolygonSoup soup;
    Labels parts, groups;
    std::vector<Labels> people;
};

struct Errors {
    double parts = 0, groups = 0, people = 0;  ///< people: among each other
    double part_count = 0, group_count = 0;
    double models = 0;

    void add(const Errors& e)
    {
        parts += e.parts, groups += e.groups, people += e.people;
        part_count += e.part_count, group_count += e.group_count;
        models += 1;
    }
    [[nodiscard]] Errors mean() const
    {
        return {parts / models, groups / models, people / models, part_count / models, group_count / models, models};
    }
};

double count_of(const Labels& labels) { return 1.0 + *std::max_element(labels.begin(), labels.end()); }

Errors errors_of(const Model& m)
{
    Errors e;
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < m.people.size(); ++i) {
        e.parts += rand_index_error(m.parts, m.people[i]) / static_cast<double>(m.people.size());
        e.groups += rand_index_error(m.groups, m.people[i]) / static_cast<double>(m.people.size());
        for (std::size_t j = 0; j < i; ++j, ++pairs) e.people += rand_index_error(m.people[i], m.people[j]);
    }
    if (pairs > 0) e.people /= static_cast<double>(pairs);
    e.part_count = count_of(m.parts);
    e.group_count = count_of(m.groups);
    e.models = 1;
    return e;
}

/// The person who agrees best with the others.
const Labels& usual_person(const Model& m)
{
    std::size_t best = 0;
    double least = 0;
    for (std::size_t i = 0; i < m.people.size(); ++i) {
        double sum = 0;
        for (const Labels& other : m.people) sum += rand_index_error(m.people[i], other);
        if (i == 0 || sum < least) {
            least = sum;
            best = i;
        }
    }
    return m.people[best];
}

Model made(const std::filesystem::path& folder, std::size_t number, bool printed)
{
    Model m;
    m.number = number;
    const std::filesystem::path path = folder / "models" / (std::to_string(number) + ".off");
    BakeMeshOptions options;
    const std::function<void(io::PolygonSoup&)> keep = [&](const io::PolygonSoup& read) { m.soup = read; };
    options.mesh.as_read = &keep;
    options.bake.locator = options.bake.exact = false;  // parts alone count
    options.bake.target_error = 100;
    const BakedModel baked = bake_mesh(path, options);
    const decompose::Partition partition =
        printed ? decompose::decompose(baked.mesh.mesh, decompose::printed_cuts()) : baked.report.partition;
    m.parts = app::polygon_labels(m.soup, baked.mesh, partition.part_of_triangle);
    std::vector<std::uint32_t> groups;
    for (const std::uint32_t part : partition.part_of_triangle)
        groups.push_back(printed ? part : model::group_of_part(baked.view(), part));
    m.groups = app::polygon_labels(m.soup, baked.mesh, groups);
    for (std::size_t k = 0; k < k_max_people; ++k) {
        const std::filesystem::path person = folder / "humans" / (std::to_string(number) + "_" + std::to_string(k) + ".seg.gz");
        if (std::filesystem::exists(person)) m.people.push_back(read_labels(person, m.soup.polygon_offsets.size() - 1));
    }
    if (m.people.empty()) throw std::runtime_error(path.string() + ": no person's labels in " + (folder / "humans").string());
    return m;
}

/// Labels in the colours of the reference's labels that they share most polygons with; others get colours of their own.
std::vector<app::Rgb> colours_of(const Labels& labels, const Labels& reference)
{
    std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> shared;
    for (std::size_t i = 0; i < labels.size(); ++i) ++shared[{labels[i], reference[i]}];
    std::vector<std::pair<std::size_t, std::pair<std::int32_t, std::int32_t>>> order;
    for (const auto& [pair, count] : shared) order.emplace_back(count, pair);
    std::sort(order.rbegin(), order.rend());
    std::map<std::int32_t, std::size_t> colour;
    std::map<std::size_t, bool> used;
    for (const auto& [count, pair] : order) {
        const auto wanted = static_cast<std::size_t>(std::max(pair.second, 0));
        if (colour.contains(pair.first) || used[wanted]) continue;
        colour[pair.first] = wanted;
        used[wanted] = true;
    }
    std::size_t next = 0;
    std::vector<app::Rgb> out;
    for (const std::int32_t label : labels) {
        if (!colour.contains(label)) {
            while (used[next]) ++next;
            used[next] = true;
            colour[label] = next;
        }
        out.push_back(app::part_colour(colour[label]));
    }
    return out;
}

app::Image picture(const Model& m, const Labels& labels)
{
    app::Layer layer;
    layer.mesh.vertices = m.soup.positions;
    const std::vector<app::Rgb> colours = colours_of(labels, m.groups);
    for (std::size_t p = 0; p < labels.size(); ++p)
        for (std::uint32_t k = m.soup.polygon_offsets[p] + 2; k < m.soup.polygon_offsets[p + 1]; ++k) {
            const auto corner = [&](std::uint32_t i) { return static_cast<std::uint32_t>(m.soup.indices[i]); };
            layer.mesh.triangles.push_back({corner(m.soup.polygon_offsets[p]), corner(k - 1), corner(k)});
            layer.colours.push_back(colours[p]);
            layer.groups.push_back(static_cast<std::uint32_t>(labels[p]));
        }
    app::View view{.width = 210, .height = 200, .shadows = false, .samples = 2, .sky_rays = 16};
    view.azimuth = app::broad_azimuth(layer.mesh, view.up);
    return app::render({layer}, view);
}

/// Two models a row; of each its parts, its groups, and the usual person's, under its number and its three errors.
class Sheet {
public:
    void add(const Model& m, const Errors& e)
    {
        const Labels& person = usual_person(m);
        app::Image cell = app::beside(app::beside(picture(m, m.parts), picture(m, m.groups)), picture(m, person));
        char text[64];
        std::snprintf(text, sizeof text, "%zu  %.2f  %.2f  %.2f", m.number, e.parts, e.groups, e.people);
        app::draw_text(cell, 6, 6, 1, text, app::srgb(0x202020));
        row_ = app::beside(row_, cell);
        if (++in_row_ == 2) end_row();
    }
    [[nodiscard]] app::Image image()
    {
        if (in_row_ > 0) end_row();
        int width = 0, height = 0;
        for (const app::Image& row : rows_) {
            width = std::max(width, row.width);
            height += row.height;
        }
        app::Image out(width, height, app::srgb(0xffffff));
        int top = 0;
        for (const app::Image& row : rows_) {
            for (int y = 0; y < row.height; ++y)
                for (int x = 0; x < row.width; ++x) out.at(x, top + y) = row.at(x, y);
            top += row.height;
        }
        return out;
    }

private:
    void end_row()
    {
        rows_.push_back(std::move(row_));
        row_ = {};
        in_row_ = 0;
    }

    std::vector<app::Image> rows_;
    app::Image row_;
    int in_row_ = 0;
};

void write_labels(const std::filesystem::path& folder, const Model& m)
{
    std::filesystem::create_directories(folder);
    std::string text = "part,group\n";
    for (std::size_t p = 0; p < m.parts.size(); ++p)
        text += std::to_string(m.parts[p]) + "," + std::to_string(m.groups[p]) + "\n";
    io::replace_file(folder / (std::to_string(m.number) + ".csv"), std::as_bytes(std::span(text)));
}

std::vector<std::size_t> model_numbers(const std::filesystem::path& folder)
{
    std::vector<std::size_t> numbers;
    for (std::size_t n = 1; n <= 20 * k_classes.size(); ++n)
        if (std::filesystem::exists(folder / "models" / (std::to_string(n) + ".off"))) numbers.push_back(n);
    if (numbers.empty()) throw std::runtime_error(folder.string() + ": no models/N.off, N from 1 to 400");
    return numbers;
}

void print_row(const char* name, const Errors& e)
{
    std::printf("| %s | %.0f | %.1f | %.1f | %.3f | %.3f | %.3f |\n", name, e.models, e.part_count, e.group_count, e.parts,
                e.groups, e.people);
}

}  // namespace

int sqmap::bench::measure_segmentation(int argc, char** argv)
{
    const Options options = parsed(argc, argv);
    if (options.folder.empty()) return k_wrong_usage;
    std::map<std::size_t, Errors> classes;
    Sheet sheet;
    for (const std::size_t number : model_numbers(options.folder)) {
        const Model m = made(options.folder, number, options.printed);
        const Errors e = errors_of(m);
        std::fprintf(stderr, "%zu: %.0f parts %.3f, %.0f groups %.3f, people %.3f\n", number, e.part_count, e.parts,
                     e.group_count, e.groups, e.people);
        classes[(number - 1) / 20].add(e);
        if (!options.labels.empty()) write_labels(options.labels, m);
        if (!options.sheet.empty()) sheet.add(m, e);
    }
    std::puts("| class | models | parts | groups | Rand index error of parts | of groups | people among each other |");
    std::puts("|---|---:|---:|---:|---:|---:|---:|");
    Errors all;
    for (const auto& [k, sum] : classes) {
        print_row(k_classes[k], sum.mean());
        all.add(sum.mean());
    }
    print_row("mean", all.mean());
    if (!options.sheet.empty()) app::write_png(options.sheet, sheet.image());
    return 0;
}
