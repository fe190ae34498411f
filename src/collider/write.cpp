#include "collider/elements.h"
#include "collider/numbers.h"
#include "io/replace_file.h"
#include "sqmap/collider/export.h"
#include "sqmap/io/write_mesh.h"
#include "sqmap/mesh/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <span>
#include <utility>

namespace sqmap::collider {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// The files of one export: its own text, and those of the meshes to which the text refers.
struct Draft {
    const Colliders& colliders;
    fs::path path;
    std::vector<ExportFile> files{};
    std::string text{};

    /// Adds a shape's hull as a file of its own; the name of that file.
    std::string mesh_file(const Colliders::Item& item)
    {
        const std::string name = path.stem().string() + '_' + item.name + ".obj";
        files.push_back({path.parent_path() / name, obj_text(as_hull(item.shape, item.points).hull, item.name)});
        return name;
    }
    void comment(const std::string& indent, const std::string& words) { text += indent + "<!-- " + words + " -->\n"; }
    /// How the file came to be, as words.
    [[nodiscard]] std::string header() const
    {
        const auto certified = [](const Colliders::Item& item) { return item.certified; };
        return "sqmap export: " + std::to_string(colliders.items.size()) +
               (colliders.is_cover() ? " balls, together certified to hold the solid"
                : std::all_of(colliders.items.begin(), colliders.items.end(), certified)
                    ? " shapes, each certified to hold its part"
                    : " shapes, not all certified to hold their parts") +
               " as written here; lengths in the mesh's units. Whole: " + words(colliders.whole);
    }
};

std::string attribute(const char* name, const std::string& value) { return std::string(" ") + name + "=\"" + value + '"'; }

void urdf(Draft& d)
{
    d.text = "<?xml version=\"1.0\"?>\n<robot" + attribute("name", escaped(d.colliders.name)) + ">\n";
    d.comment("  ", d.header());
    d.text += "  <link" + attribute("name", escaped(d.colliders.name)) + ">\n";
    for (const Colliders::Item& item : d.colliders.items) {
        const Shape& s = item.shape;
        d.comment("    ", words(item.figures));
        d.text += "    <collision" + attribute("name", escaped(item.name)) + ">\n";
        if (is_in_urdf(s.kind))
            d.text += "      <origin" + attribute("xyz", text(s.xyz)) + attribute("rpy", text(s.rpy)) + "/>\n";
        d.text += "      <geometry>";
        if (s.kind == Kind::Box)
            d.text += "<box" + attribute("size", text(2. * s.size));
        else if (s.kind == Kind::Sphere)
            d.text += "<sphere" + attribute("radius", text(s.size.x));
        else if (s.kind == Kind::Cylinder)
            d.text += "<cylinder" + attribute("radius", text(s.size.x)) + attribute("length", text(2 * s.size.z));
        else
            d.text += "<mesh" + attribute("filename", escaped(d.mesh_file(item)));
        d.text += "/></geometry>\n    </collision>\n";
    }
    d.text += "  </link>\n</robot>\n";
}

void mjcf(Draft& d)
{
    std::string assets, geoms;
    for (const Colliders::Item& item : d.colliders.items) {
        const Shape& s = item.shape;
        const std::string name = escaped(item.name);
        geoms += "      <!-- " + words(item.figures) + " -->\n      <geom" + attribute("name", name);
        if (is_primitive(s.kind)) {
            const Quaternion q = quaternion_of_rpy(s.rpy);
            geoms += attribute("type", name_of(s.kind)) + attribute("pos", text(s.xyz)) +
                     attribute("quat", text(q.w) + ' ' + text(Vec3d{q.x, q.y, q.z}));
            const bool is_round = s.kind == Kind::Capsule || s.kind == Kind::Cylinder;
            geoms += attribute("size", s.kind == Kind::Sphere ? text(s.size.x)
                                       : is_round             ? text(s.size.x) + ' ' + text(s.size.z)
                                                              : text(s.size));
        } else {
            // MuJoCo takes the convex hull of a mesh's vertices for contacts.
            assets += "    <mesh" + attribute("name", name) + " vertex=\"";
            for (const Vec3d& v : as_hull(s, item.points).hull.vertices) assets += text(v) + "  ";
            assets += "\"/>\n";
            geoms += attribute("type", "mesh") + attribute("mesh", name);
        }
        geoms += "/>\n";
    }
    d.text = "<mujoco" + attribute("model", escaped(d.colliders.name)) + ">\n";
    d.comment("  ", d.header());
    if (!assets.empty()) d.text += "  <asset>\n" + assets + "  </asset>\n";
    d.text += "  <worldbody>\n    <body" + attribute("name", escaped(d.colliders.name)) + ">\n      <freejoint/>\n" + geoms +
              "    </body>\n  </worldbody>\n</mujoco>\n";
}

std::string sdf_geometry(Draft& d, const Colliders::Item& item)
{
    const Shape& s = item.shape;
    const auto element = [](const char* name, const std::string& value) {
        return '<' + std::string(name) + '>' + value + "</" + name + '>';
    };
    switch (s.kind) {
        case Kind::Box:
            return element("box", element("size", text(2. * s.size)));
        case Kind::Sphere:
            return element("sphere", element("radius", text(s.size.x)));
        case Kind::Ellipsoid:
            return element("ellipsoid", element("radii", text(s.size)));
        case Kind::Capsule:
        case Kind::Cylinder:
            return element(name_of(s.kind), element("radius", text(s.size.x)) + element("length", text(2 * s.size.z)));
        default:
            return element("mesh", element("uri", escaped(d.mesh_file(item))));
    }
}

void sdf(Draft& d)
{
    d.text = "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n  <model" + attribute("name", escaped(d.colliders.name)) + ">\n";
    d.comment("    ", d.header());
    d.text += "    <link" + attribute("name", escaped(d.colliders.name)) + ">\n";
    for (const Colliders::Item& item : d.colliders.items) {
        d.comment("      ", words(item.figures));
        d.text += "      <collision" + attribute("name", escaped(item.name)) + ">\n";
        if (is_primitive(item.shape.kind))
            d.text += "        <pose>" + text(item.shape.xyz) + ' ' + text(item.shape.rpy) + "</pose>\n";
        d.text += "        <geometry>" + sdf_geometry(d, item) + "</geometry>\n      </collision>\n";
    }
    d.text += "    </link>\n  </model>\n</sdf>\n";
}

void srdf(Draft& d)
{
    d.text = "<?xml version=\"1.0\"?>\n<robot" + attribute("name", escaped(d.colliders.name)) + ">\n";
    d.comment("  ", d.header());
    d.text += "  <link_sphere_approximation" + attribute("link", escaped(d.colliders.name)) + ">\n";
    for (const Colliders::Item& item : d.colliders.items)
        d.text +=
            "    <sphere" + attribute("center", text(item.shape.xyz)) + attribute("radius", text(item.shape.size.x)) + "/>\n";
    d.text += "  </link_sphere_approximation>\n</robot>\n";
}

void spheres(Draft& d)
{
    d.text = "# " + d.header() + "\ncollision_spheres:\n  " + ordered_json(d.colliders.name).dump() + ":\n";
    for (const Colliders::Item& item : d.colliders.items)
        d.text += "    - \"center\": [" + text(item.shape.xyz, ", ") + "]\n      \"radius\": " + text(item.shape.size.x) + '\n';
}

ordered_json as_json(const Figures& f)
{
    const auto known = [](double v) { return v >= 0 ? ordered_json(v) : ordered_json(nullptr); };
    return {{"volume", f.volume},
            {"volume_ratio", known(f.volume_ratio)},
            {"support_excess", known(f.support_excess)},
            {"protrusion", known(f.protrusion)},
            {"coverage", known(f.coverage)}};
}

void json(Draft& d)
{
    ordered_json out{{"name", d.colliders.name},
                     {"units",
                      "those of the mesh; angles in radians; rotation of a superquadric: rows that turn the mesh's axes into "
                      "the part's"},
                     {"figures", as_json(d.colliders.whole)},
                     {"parts", ordered_json::array()}};
    for (const Colliders::Item& item : d.colliders.items) {
        ordered_json part = ordered_json::parse(parameters_json(item.shape, item.name));
        part["certified"] = item.certified;
        part["figures"] = as_json(item.figures);
        out["parts"].push_back(std::move(part));
    }
    d.text = out.dump(1) + '\n';
}

void obj(Draft& d)
{
    d.text = "# " + d.header() + '\n';
    std::size_t first = 1;
    for (const Colliders::Item& item : d.colliders.items) {
        const mesh::Mesh hull = as_hull(item.shape, item.points).hull;
        d.text += "# " + words(item.figures) + '\n' + obj_text(hull, item.name, first);
        first += hull.vertices.size();
    }
}

void glb(Draft& d)
{
    std::vector<io::MovingMesh> meshes;
    for (const Colliders::Item& item : d.colliders.items) {
        const mesh::Mesh hull = as_hull(item.shape, item.points, Precision::Float).hull;
        ordered_json extras = ordered_json::parse(parameters_json(item.shape, item.name));
        extras["figures"] = as_json(item.figures);
        meshes.push_back({.name = item.name,
                          .positions = hull.vertices,
                          .triangles = hull.triangles,
                          .colour = {0.35f, 0.55f, 0.8f},
                          .flat = true,
                          .group = d.colliders.name,
                          .extras = ordered_json{{"collider", extras}}.dump()});
    }
    const std::vector<std::byte> bytes = io::glb_bytes(meshes);
    d.text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace

std::vector<ExportFile> files_of(const Colliders& colliders, Format format, const fs::path& path)
{
    for (const Colliders::Item& item : colliders.items)
        if (holds_spheres_alone(format) && item.shape.kind != Kind::Sphere)
            throw mesh::InvalidInput(std::string("the format ") + name_of(format) + " holds spheres alone: take spheres");
    constexpr void (*k_writers[])(Draft&) = {urdf, mjcf, sdf, srdf, spheres, json, obj, glb};
    Draft draft{colliders, path};
    k_writers[static_cast<std::size_t>(format)](draft);
    draft.files.push_back({path, std::move(draft.text)});
    return std::move(draft.files);
}

void write(const std::vector<ExportFile>& files)
{
    for (const ExportFile& f : files) io::replace_file(f.path, std::as_bytes(std::span(f.bytes)));
}

std::string report_json(const Colliders& colliders)
{
    ordered_json out{{"name", colliders.name}, {"whole", as_json(colliders.whole)}, {"shapes", ordered_json::array()}};
    for (const Colliders::Item& item : colliders.items) {
        ordered_json figures = as_json(item.figures);
        figures["name"] = item.name;
        figures["shape"] = name_of(item.shape.kind);
        out["shapes"].push_back(std::move(figures));
    }
    return out.dump(2);
}

}  // namespace sqmap::collider
