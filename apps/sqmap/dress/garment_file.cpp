#include "dress/garment_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

namespace sqmap::app {
namespace {

using nlohmann::json;

/// One object of the file; every key must be asked for, so that a misspelt one is an error and not a surprise.
class Reader {
public:
    Reader(const json& object, std::string where) : object_(object), where_(std::move(where))
    {
        if (!object_.is_object()) fail("", "must be an object");
    }

    double number(const char* key, double fallback)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_number() || !std::isfinite(v->get<double>())) fail(key, "must be a number");
        return v->get<double>();
    }
    std::string text(const char* key, const std::string& fallback)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_string()) fail(key, "must be text");
        return v->get<std::string>();
    }
    Vec3d place(const char* key, Vec3d fallback)
    {
        const json* v = find(key);
        if (v == nullptr) return fallback;
        if (!v->is_array() || v->size() != 3 || !std::all_of(v->begin(), v->end(), [](const json& n) { return n.is_number(); }))
            fail(key, "must be three numbers");
        return {(*v)[0].get<double>(), (*v)[1].get<double>(), (*v)[2].get<double>()};
    }
    std::uint32_t vertices(std::uint32_t fallback)
    {
        const double n = number("vertices", fallback);
        if (!(n >= 12 && n <= 1e6)) fail("vertices", "must be from 12 to 1000000");
        return static_cast<std::uint32_t>(n);
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
    Reader own(*v, "fabric");
    name = own.text("like", "cotton");
    sim::Fabric f = sim::fabric(name);
    f.density = own.number("density", f.density);
    f.stretch = own.number("stretch", f.stretch);
    f.shear = own.number("shear", f.shear);
    f.bend = own.number("bend", f.bend);
    f.damping = own.number("damping", f.damping);
    f.friction = own.number("friction", f.friction);
    f.thickness = own.number("thickness", f.thickness);
    own.done();
    if (!(f.density > 0 && f.stretch > 0 && f.shear > 0 && f.bend > 0 && f.damping >= 0 && f.friction >= 0 && f.thickness > 0))
        reader.fail("fabric", "has a number below its range");
    name += ", changed";
    return f;
}

}  // namespace

GarmentFile read_garment(const std::filesystem::path& path)
{
    std::ifstream in(path);
    const json root = json::parse(in, nullptr, false, true);
    if (root.is_discarded()) throw GarmentFileError(path.string() + ": the file is not JSON");
    GarmentFile out;
    out.name = path.stem().string();
    try {
        Reader r(root, path.string());
        const std::string pattern = r.text("pattern", "");
        out.fabric = read_fabric(r, out.fabric_name);
        if (pattern == "poncho" || pattern == "blanket") {
            sim::SheetPattern p;
            p.centre = r.place("centre", p.centre);
            p.width = r.number("width", p.width);
            p.depth = r.number("depth", p.depth);
            if (pattern == "poncho") {
                p.hole_x = r.number("hole_x", 0.15);
                p.hole_z = r.number("hole_z", 0.15);
            }
            p.vertices = r.vertices(p.vertices);
            out.garment = sim::sheet(p);
        } else if (pattern == "skirt") {
            sim::SkirtPattern p;
            p.centre = r.place("centre", p.centre);
            p.waist_radius = r.number("waist_radius", p.waist_radius);
            p.length = r.number("length", p.length);
            p.vertices = r.vertices(p.vertices);
            out.garment = sim::skirt(p);
            out.waist_bone = r.text("waist_bone", "world");
        } else if (pattern == "shirt") {
            sim::ShirtPattern p;
            p.collar = r.place("collar", p.collar);
            p.chest = r.number("chest", p.chest);
            p.length = r.number("length", p.length);
            p.span = r.number("span", p.span);
            p.sleeve = r.number("sleeve", p.sleeve);
            p.neck = r.number("neck", p.neck);
            p.gap = r.number("gap", p.gap);
            p.vertices = r.vertices(p.vertices);
            out.garment = sim::shirt(p);
        } else {
            r.fail("pattern", "must be poncho, blanket, skirt or shirt");
        }
        for (const bool sew : {false, true})
            r.each(sew ? "sew" : "cut", [&](Reader& e) {
                out.seam_events.push_back({e.text("seam", ""), e.number("at", 0), sew});
            });
        for (const SeamEvent& e : out.seam_events)
            if (std::none_of(out.garment.seams.begin(), out.garment.seams.end(),
                             [&](const sim::Seam& s) { return s.name == e.seam; }))
                r.fail(e.sew ? "sew" : "cut", "names a seam that the pattern does not have (a shirt has shoulders and sides)");
        r.each("pull", [&](Reader& e) {
            Pull p;
            p.at = e.number("at", 0);
            p.until = e.number("until", p.at + 1);
            p.near = e.place("near", {});
            p.by = e.place("by", {0, 0.1, 0});
            p.radius = e.number("radius", p.radius);
            out.pulls.push_back(p);
        });
        r.done();
    } catch (const std::invalid_argument& e) {
        throw GarmentFileError(path.string() + ": " + e.what());
    }
    return out;
}

}  // namespace sqmap::app
