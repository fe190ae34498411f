#include "common/dress/garment_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>

namespace sqmap::app {
namespace {

using nlohmann::json;

constexpr double k_longest = 20, k_farthest = 1000;  // m

/// One object of the file; every key must be asked for, so that a misspelt one is an error and not a surprise.
class Reader {
public:
    Reader(const json& object, std::string where) : object_(object), where_(std::move(where))
    {
        if (!object_.is_object()) fail("", "must be an object");
    }

    double number(const char* key, double fallback, double least, double max)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_number()) fail(key, "must be a number");
        const double number = v->get<double>();
        if (!(number >= least && number <= max)) {
            char text[100];
            std::snprintf(text, sizeof text, "is %g: it must be from %g to %g", number, least, max);
            fail(key, text);
        }
        return number;
    }
    double length(const char* key, double fallback) { return number(key, fallback, 0.001, k_longest); }
    double time(const char* key, double fallback) { return number(key, fallback, 0, 1e6); }
    std::string text(const char* key, const std::string& fallback)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_string()) fail(key, "must be text");
        return v->get<std::string>();
    }
    Vec3d position(const char* key, Vec3d fallback)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_array() || v->size() != 3 || !std::all_of(v->begin(), v->end(), [](const json& n) { return n.is_number(); }))
            fail(key, "must be three numbers");
        const Vec3d position{(*v)[0].get<double>(), (*v)[1].get<double>(), (*v)[2].get<double>()};
        if (!(norm(position) <= k_farthest)) fail(key, "is farther than 1000 m from the origin: are these metres?");
        return position;
    }
    std::uint32_t vertices(std::uint32_t fallback)
    {
        return static_cast<std::uint32_t>(number("vertices", fallback, 12, 200000));
    }
    template <class Take>
    void each(const char* key, Take&& take)
    {
        const json* v = find(key);
        if (v == nullptr) return;
        if (!v->is_array()) fail(key, "must be a list");
        for (const json& item : *v) {
            Reader reader(item, where_ + ": " + key);
            take(reader);
            reader.done();
        }
    }
    const json* find(const char* key)
    {
        known_.insert(key);
        const auto found = object_.find(key);
        return found == object_.end() ? nullptr : &*found;
    }
    void done() const
    {
        for (const auto& [key, value] : object_.items())
            if (known_.count(key) == 0) fail(key.c_str(), "is not known here");
    }
    [[nodiscard]] const std::string& where() const { return where_; }
    [[noreturn]] void fail(const char* key, const char* what) const
    {
        throw GarmentFileError(where_ + ": " + (key[0] != 0 ? "'" + std::string(key) + "' " : "") + what);
    }

private:
    const json& object_;
    std::string where_;
    std::set<std::string> known_;
};

sim::Fabric read_fabric(Reader& reader, std::string& name)
{
    const json* v = reader.find("fabric");
    if (v == nullptr || v->is_string()) {
        name = v == nullptr ? "cotton" : v->get<std::string>();
        return sim::fabric(name);
    }
    Reader own(*v, reader.where() + ": fabric");
    name = own.text("like", "cotton");
    sim::Fabric f = sim::fabric(name);
    f.density = own.number("density", f.density, 0.001, 20);
    f.stretch = own.number("stretch", f.stretch, 1e-4, 1);
    f.shear = own.number("shear", f.shear, 1, 1e5);
    f.bend = own.number("bend", f.bend, 0, 0.1);
    f.damping = own.number("damping", f.damping, 0, 1000);
    f.friction = own.number("friction", f.friction, 0, 10);
    f.thickness = own.number("thickness", f.thickness, 1e-4, 0.02);
    own.done();
    name += ", changed";
    return f;
}

void read_pattern(Reader& r, GarmentFile& out)
{
    const std::string pattern = r.text("pattern", "");
    if (pattern == "poncho" || pattern == "blanket") {
        sim::SheetPattern p;
        p.centre = r.position("centre", p.centre);
        p.width = r.length("width", p.width);
        p.depth = r.length("depth", p.depth);
        if (pattern == "poncho") {
            p.hole_x = r.number("hole_x", 0.15, 0, 0.45 * p.width);
            p.hole_z = r.number("hole_z", 0.15, 0, 0.45 * p.depth);
        }
        p.vertices = r.vertices(p.vertices);
        out.garment = sim::sheet(p);
    } else if (pattern == "skirt") {
        sim::SkirtPattern p;
        p.centre = r.position("centre", p.centre);
        p.waist_radius = r.length("waist_radius", p.waist_radius);
        p.length = r.length("length", p.length);
        p.vertices = r.vertices(p.vertices);
        out.garment = sim::skirt(p);
        out.waist_bone = r.text("waist_bone", "world");
    } else if (pattern == "shirt") {
        sim::ShirtPattern p;
        p.collar = r.position("collar", p.collar);
        p.chest = r.length("chest", p.chest);
        p.length = r.length("length", p.length);
        p.span = r.length("span", p.span);
        p.sleeve = r.length("sleeve", p.sleeve);
        p.neck = r.length("neck", p.neck);
        p.gap = r.length("gap", p.gap);
        p.vertices = r.vertices(p.vertices);
        out.garment = sim::shirt(p);
    } else {
        r.fail("pattern", "must be poncho, blanket, skirt or shirt");
    }
}

void read_seams(Reader& r, GarmentFile& out)
{
    for (const bool sew : {false, true})
        r.each(sew ? "sew" : "cut", [&](Reader& e) { out.seam_events.push_back({e.text("seam", ""), e.time("at", 0), sew}); });
    for (const SeamEvent& e : out.seam_events)
        if (std::none_of(out.garment.seams.begin(), out.garment.seams.end(),
                         [&](const sim::Seam& s) { return s.name == e.seam; }))
            r.fail(e.sew ? "sew" : "cut", "names a seam that the pattern does not have (a shirt has shoulders and sides)");
}

void read_pulls(Reader& r, GarmentFile& out)
{
    r.each("pull", [&](Reader& e) {
        Pull p;
        p.at = e.time("at", 0);
        p.until = e.time("until", p.at + 1);
        if (!(p.until > p.at)) e.fail("until", "must be later than 'at'");
        p.near = e.position("near", {});
        p.by = e.position("by", {0, 0.1, 0});
        p.radius = e.number("radius", p.radius, 0, k_longest);
        out.pulls.push_back(p);
    });
    std::sort(out.pulls.begin(), out.pulls.end(), [](const Pull& a, const Pull& b) { return a.at < b.at; });
    for (std::size_t i = 1; i < out.pulls.size(); ++i)
        if (out.pulls[i].at < out.pulls[i - 1].until) r.fail("pull", "has two at one time: there is one tool, use it in turns");
}

void read_pins(Reader& r, GarmentFile& out)
{
    r.each("pin", [&](Reader& e) {
        PinEvent p;
        p.at = e.time("at", 0);
        p.until = e.number("until", INFINITY, 0, 1e6);
        if (!(p.until > p.at)) e.fail("until", "must be later than 'at'");
        p.near = e.position("near", {});
        p.radius = e.number("radius", p.radius, 0, k_longest);
        p.bone = e.text("bone", "world");
        out.pins.push_back(p);
    });
}

}  // namespace

GarmentFile read_garment(const std::filesystem::path& path)
{
    std::ifstream in(path);
    json root;
    try {
        root = json::parse(in, nullptr, true, true);
    } catch (const json::exception& e) {
        // "[json.exception.parse_error.101] parse error at line 1, column 5: ..."
        const std::string text = e.what();
        throw GarmentFileError(path.string() +
                               ": the file is not JSON: " + text.substr(std::min(text.size(), text.find("] ") + 2)));
    }
    GarmentFile out;
    out.name = path.stem().string();
    try {
        Reader r(root, path.string());
        out.fabric = read_fabric(r, out.fabric_name);
        read_pattern(r, out);
        read_seams(r, out);
        read_pulls(r, out);
        read_pins(r, out);
        r.done();
    } catch (const std::invalid_argument& e) {
        throw GarmentFileError(path.string() + ": " + e.what());
    }
    return out;
}

}  // namespace sqmap::app
