#include "sqmap/robot/rewrite.h"

#include "collider/elements.h"
#include "collider/numbers.h"
#include "collider/pieces.h"
#include "parallel/for_each.h"
#include "robot/xml.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <utility>

namespace sqmap::robot {
namespace {

namespace fs = std::filesystem;
using collider::Colliders;
using collider::Kind;
using collider::Shape;

/// A collision element with a mesh on its path to shapes.
struct Task {
    pugi::xml_node node{};
    std::string link;
    const CollisionMesh* mesh = nullptr;
    RewrittenMesh row;
    Colliders colliders{};
};

/// A name for files and elements: letters, digits, '-', '_' and '.' of another.
std::string harmless(std::string name)
{
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_') c = '_';
    return name;
}

void make_shapes(Task& task, const fs::path& robot_file, const RewriteOptions& options)
{
    try {
        const LinkMesh loaded = load_mesh(mesh_path(task.mesh->filename, robot_file, options.packages), *task.mesh, options.mesh);
        task.row.triangles = loaded.soup.triangles.size();
        const bool is_solid = !loaded.admitted.refused() && loaded.admitted.solid;
        task.row.verdict =
            loaded.admitted.refused() ? mesh::name_of(loaded.admitted.diagnosis.code) : mesh::name_of(loaded.admitted.admission);
        // A mesh that was taken unchanged is its own solid. Of any other, its shapes hold the triangles of the file too: a repair
        // may have dropped or moved some.
        std::vector<std::array<Vec3d, 3>> held;
        const bool is_unchanged = is_solid && loaded.admitted.admission == mesh::Admission::Accept;
        if (!is_unchanged)
            for (const mesh::Triangle& t : loaded.soup.triangles)
                held.push_back({loaded.soup.vertices[t[0]], loaded.soup.vertices[t[1]], loaded.soup.vertices[t[2]]});
        collider::Pieces pieces =
            collider::pieces_of({.name = harmless(task.row.link),
                                 .triangles = held,
                                 .solid = is_solid ? &loaded.admitted.mesh : nullptr,
                                 .crossed = loaded.admitted.crossed},
                                {.max_parts = options.max_parts,
                                 .threads = 1,
                                 .superquadrics = options.shape.spheres == 0 && options.shape.kind == Kind::Superquadric});
        task.colliders = collider::colliders_of(pieces, options.shape, 1);
        task.row.shapes = task.colliders.items.size();
        task.row.figures = task.colliders.whole;
    } catch (const mesh::RefusedMesh& e) {
        task.row.problem = mesh::Words(e.what()) + " (" + e.diagnosis().cure + ")";
    } catch (const mesh::Error& e) {
        task.row.problem = e.what();
    }
}

void set_attribute(pugi::xml_node& node, const char* name, const std::string& value)
{
    node.append_attribute(name).set_value(value.c_str());
}

class Writer {
public:
    Writer(const fs::path& output, const Packages& packages) : output_(output), packages_(packages) {}

    /// Puts elements with the task's shapes in the place of its element.
    void replace(Task& task)
    {
        pugi::xml_node parent = task.node.parent();
        const std::string indent = indent_of(task.node);
        const std::string base = task.node.attribute("name").value();
        for (std::size_t i = 0; i < task.colliders.items.size(); ++i) {
            const Colliders::Item& item = task.colliders.items[i];
            if (i > 0) parent.insert_child_before(pugi::node_pcdata, task.node).set_value(indent.c_str());
            pugi::xml_node made = parent.insert_copy_before(task.node, task.node);
            if (task.colliders.items.size() > 1 || base.empty()) {
                made.remove_attribute("name");
                const std::string name = base.empty() ? item.name : base + '_' + std::to_string(i);
                made.prepend_attribute("name").set_value(name.c_str());
            }
            fill(made, item, words_of(task.colliders, i), indent);
        }
        parent.remove_child(task.node);
    }

    std::vector<collider::ExportFile> files{};

private:
    static std::string indent_of(const pugi::xml_node& node)
    {
        const pugi::xml_node before = node.previous_sibling();
        if (before.type() != pugi::node_pcdata) return "\n";
        const std::string text = before.value();
        const std::size_t line = text.rfind('\n');
        return line == std::string::npos ? "\n" : text.substr(line);
    }

    /// The comment of a shape. The first shape's says what all shapes together cost.
    static std::string words_of(const Colliders& colliders, std::size_t i)
    {
        const std::size_t count = colliders.items.size();
        std::string out = " sqmap: ";
        if (count == 1)
            out += "certified to hold the mesh";
        else if (colliders.is_cover())
            out += "one of " + std::to_string(count) + " balls that are certified to hold the mesh together";
        else
            out += "certified to hold its part; " + collider::words(colliders.items[i].figures);
        if (i == 0) out += (count > 1 ? "; all together: " : "; ") + collider::words(colliders.whole);
        return out + ' ';
    }

    void fill(pugi::xml_node& collision, const Colliders::Item& item, const std::string& words, const std::string& indent)
    {
        for (const char* name : {"origin", "geometry"})
            while (const pugi::xml_node old = collision.child(name)) {
                const pugi::xml_node gap = old.previous_sibling();
                if (gap.type() == pugi::node_pcdata) collision.remove_child(gap);
                collision.remove_child(old);
            }
        // In front of what else the element holds, in this order: comment, origin, geometry.
        pugi::xml_node geometry = collision.prepend_child("geometry");
        put_shape(geometry, item);
        const std::string inner = indent + "  ";
        collision.prepend_child(pugi::node_pcdata).set_value(inner.c_str());
        if (collider::is_in_urdf(item.shape.kind)) {
            pugi::xml_node origin = collision.prepend_child("origin");
            set_attribute(origin, "xyz", collider::text(item.shape.xyz));
            set_attribute(origin, "rpy", collider::text(item.shape.rpy));
            collision.prepend_child(pugi::node_pcdata).set_value(inner.c_str());
        }
        collision.prepend_child(pugi::node_comment).set_value(words.c_str());
        collision.prepend_child(pugi::node_pcdata).set_value(inner.c_str());
        if (collision.last_child().type() != pugi::node_pcdata)
            collision.append_child(pugi::node_pcdata).set_value(indent.c_str());
    }

    void put_shape(pugi::xml_node& geometry, const Colliders::Item& item)
    {
        const Shape& s = item.shape;
        pugi::xml_node element = geometry.append_child(collider::is_in_urdf(s.kind) ? collider::name_of(s.kind) : "mesh");
        if (s.kind == Kind::Box) set_attribute(element, "size", collider::text(2. * s.size));
        if (s.kind == Kind::Sphere || s.kind == Kind::Cylinder) set_attribute(element, "radius", collider::text(s.size.x));
        if (s.kind == Kind::Cylinder) set_attribute(element, "length", collider::text(2 * s.size.z));
        if (!collider::is_in_urdf(s.kind)) set_attribute(element, "filename", mesh_file(item));
    }

    /// Adds a file with the shape's hull; how the robot file names it: by the package that it is in, else by its place beside it.
    std::string mesh_file(const Colliders::Item& item)
    {
        std::string stem = output_.stem().string() + '_' + item.name;
        while (std::any_of(files.begin(), files.end(), [&](const auto& f) { return f.path.stem() == stem; })) stem += "_2";
        const fs::path path = output_.parent_path() / (stem + ".obj");
        files.push_back({path, collider::obj_text(collider::as_hull(item.shape, item.points).hull, item.name)});
        for (const auto& [name, folder] : packages_) {
            const fs::path below = fs::weakly_canonical(path).lexically_relative(fs::weakly_canonical(folder));
            if (!below.empty() && *below.begin() != "..") return "package://" + name + '/' + below.generic_string();
        }
        return path.filename().string();
    }

    const fs::path& output_;
    const Packages& packages_;
};

/// The collision elements with meshes, beside those of the description, which were read from the same text in the same order.
std::vector<Task> tasks_of(const Description& robot, const RobotXml& xml)
{
    std::vector<Task> tasks;
    std::size_t link = 0;
    for (const pugi::xml_node& node : xml.robot().children("link")) {
        std::size_t at = 0;
        for (const pugi::xml_node& collision : node.children("collision")) {
            if (!collision.child("geometry").child("mesh")) continue;
            const CollisionMesh& m = robot.links[link].meshes[at++];
            Task task{.node = collision, .link = robot.links[link].name, .mesh = &m, .row = {}};
            task.row = {.link = task.link, .filename = m.filename, .line = m.line, .verdict = {}};
            tasks.push_back(std::move(task));
        }
        ++link;
    }
    return tasks;
}

}  // namespace

Rewritten rewrite(std::string_view text, const fs::path& robot_file, const fs::path& output, const RewriteOptions& options)
{
    const Description robot = read_description(text, robot_file.string());
    RobotXml xml(text, robot_file.string());
    std::vector<Task> tasks = tasks_of(robot, xml);
    parallel::for_each(tasks.size(), options.threads, [&](std::size_t i) { make_shapes(tasks[i], robot_file, options); });
    Writer writer(output, options.packages);
    Rewritten out;
    for (Task& task : tasks) {
        if (task.row.problem.empty()) writer.replace(task);
        out.meshes.push_back(task.row);
    }
    out.files = std::move(writer.files);
    out.files.push_back({output, xml.text()});
    return out;
}

}  // namespace sqmap::robot
