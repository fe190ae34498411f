#include "sqmap/robot/description.h"

#include "robot/xml.h"
#include "sqmap/collider/shape.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sqmap::robot {
namespace {

namespace fs = std::filesystem;

class Reader {
public:
    Reader(std::string_view text, const std::string& file) : xml_(text, file) {}

    Description run()
    {
        out_.name = xml_.robot().attribute("name").value();
        for (const pugi::xml_node& link : xml_.robot().children("link")) add_link(link);
        if (out_.links.empty()) xml_.refuse(xml_.robot(), "the robot has no links", "give a URDF file with links");
        for (const pugi::xml_node& joint : xml_.robot().children("joint")) add_joint(joint);
        for (std::size_t i = 0; i < joint_nodes_.size(); ++i) add_mimic(i);
        check_mimics();
        check_tree();
        return std::move(out_);
    }

private:
    Pose origin_of(const pugi::xml_node& node) const
    {
        const pugi::xml_node origin = node.child("origin");
        return {collider::rotation_of_rpy(xml_.vector(origin, "rpy", {})), xml_.vector(origin, "xyz", {})};
    }

    void add_link(const pugi::xml_node& node)
    {
        Link link{.name = xml_.needed(node, "name"), .line = xml_.line_of(node)};
        const std::size_t index = out_.links.size();
        if (!links_.emplace(link.name, index).second)
            xml_.refuse(node, "a second link is named '" + link.name + "'", "give each link a name of its own");
        for (const pugi::xml_node& collision : node.children("collision")) {
            const pugi::xml_node mesh = collision.child("geometry").child("mesh");
            if (!mesh) {
                add_solid(link, collision);
                continue;
            }
            CollisionMesh m{.filename = xml_.needed(mesh, "filename"),
                            .scale = xml_.vector(mesh, "scale", {1, 1, 1}),
                            .pose = origin_of(collision),
                            .line = xml_.line_of(collision)};
            if (m.scale.x == 0 || m.scale.y == 0 || m.scale.z == 0)
                xml_.refuse(mesh, "link '" + link.name + "': a scale of zero leaves nothing of its mesh",
                            "write a scale that is not zero");
            link.meshes.push_back(std::move(m));
        }
        out_.links.push_back(std::move(link));
    }

    void add_solid(Link& link, const pugi::xml_node& collision) const
    {
        const auto is_element = [](const pugi::xml_node& n) { return n.type() == pugi::node_element; };
        const pugi::xml_node shape = collision.child("geometry").find_child(is_element);
        if (!shape) return;
        CollisionSolid solid{.element = shape.name(), .size = {}, .pose = origin_of(collision), .line = xml_.line_of(collision)};
        const double radius = xml_.number(shape, "radius", 0);
        if (solid.element == "box") {
            solid.kind = CollisionSolid::Kind::Box;
            solid.size = xml_.vector(shape, "size", {});
        } else if (solid.element == "cylinder") {
            solid.kind = CollisionSolid::Kind::Cylinder;
            solid.size = {radius, radius, xml_.number(shape, "length", 0)};
        } else if (solid.element == "sphere") {
            solid.kind = CollisionSolid::Kind::Sphere;
            solid.size = {radius, radius, radius};
        }
        link.solids.push_back(std::move(solid));
    }

    std::size_t link_named(const pugi::xml_node& joint, const char* role) const
    {
        const pugi::xml_node node = joint.child(role);
        const std::string joint_name = joint.attribute("name").value();
        if (!node)
            xml_.refuse(joint, "joint '" + joint_name + "' has no " + role, std::string("give it <") + role + " link=\"...\"/>");
        const std::string name = xml_.needed(node, "link");
        const auto found = links_.find(name);
        if (found == links_.end())
            xml_.refuse(node, "joint '" + joint_name + "': there is no link '" + name + "'",
                        "name a link of the robot, or add it");
        return found->second;
    }

    void add_joint(const pugi::xml_node& node)
    {
        constexpr std::pair<const char*, JointKind> k_kinds[] = {{"fixed", JointKind::Fixed},
                                                                 {"revolute", JointKind::Revolute},
                                                                 {"continuous", JointKind::Continuous},
                                                                 {"prismatic", JointKind::Prismatic}};
        Joint joint{.name = xml_.needed(node, "name"), .kind = JointKind::Other, .line = xml_.line_of(node)};
        const std::string type = xml_.needed(node, "type");
        for (const auto& [name, kind] : k_kinds)
            if (type == name) joint.kind = kind;
        if (joint.kind == JointKind::Other && type != "floating" && type != "planar")
            xml_.refuse(node, "joint '" + joint.name + "' has the unknown type '" + type + "'",
                        "write fixed, revolute, continuous, prismatic, floating or planar");
        if (!joints_.emplace(joint.name, out_.joints.size()).second)
            xml_.refuse(node, "a second joint is named '" + joint.name + "'", "give each joint a name of its own");
        joint.parent = link_named(node, "parent");
        joint.child = link_named(node, "child");
        joint.origin = origin_of(node);
        const Vec3d axis = xml_.vector(node.child("axis"), "xyz", {1, 0, 0});
        const bool moves = joint.kind != JointKind::Fixed && joint.kind != JointKind::Other;
        if (moves && !(norm(axis) > 1e-9))
            xml_.refuse(node, "joint '" + joint.name + "' has an axis of no length", "write a direction");
        joint.axis = normalized(axis);
        const pugi::xml_node limit = node.child("limit");
        const bool is_limited = joint.kind == JointKind::Revolute || joint.kind == JointKind::Prismatic;
        if (is_limited && !limit)
            xml_.refuse(node, "joint '" + joint.name + "' has no limits", "give it <limit lower=\"...\" upper=\"...\"/>");
        constexpr double k_half_turn = 3.141592653589793;
        joint.lower = is_limited ? xml_.number(limit, "lower", 0) : (joint.kind == JointKind::Continuous ? -k_half_turn : 0);
        joint.upper = is_limited ? xml_.number(limit, "upper", 0) : -joint.lower;
        if (joint.lower > joint.upper)
            xml_.refuse(limit, "joint '" + joint.name + "': its lower limit is above its upper one", "exchange them");
        out_.joints.push_back(std::move(joint));
        joint_nodes_.push_back(node);
    }

    void add_mimic(std::size_t index)
    {
        const pugi::xml_node mimic = joint_nodes_[index].child("mimic");
        if (!mimic) return;
        Joint& joint = out_.joints[index];
        const std::string name = xml_.needed(mimic, "joint");
        const auto found = joints_.find(name);
        if (found == joints_.end())
            xml_.refuse(mimic, "joint '" + joint.name + "' mimics '" + name + "', which is no joint",
                        "name a joint of the robot");
        if (found->second == index)
            xml_.refuse(mimic, "joint '" + joint.name + "' mimics itself", "name another joint, or remove <mimic>");
        joint.mimic = {found->second, xml_.number(mimic, "multiplier", 1), xml_.number(mimic, "offset", 0)};
    }
    void check_mimics() const
    {
        for (std::size_t i = 0; i < out_.joints.size(); ++i) {
            std::size_t steps = 0;
            for (std::size_t j = i; out_.joints[j].mimics(); j = out_.joints[j].mimic.joint)
                if (++steps > out_.joints.size())
                    xml_.refuse(joint_nodes_[i],
                                "joint '" + out_.joints[i].name + "' mimics joints that mimic one another in a circle",
                                "let one of them move by itself");
        }
    }

    void check_tree()
    {
        constexpr auto k_none = static_cast<std::size_t>(-1);
        std::vector<std::size_t> joint_to(out_.links.size(), k_none);
        for (std::size_t i = 0; i < out_.joints.size(); ++i) {
            const Joint& joint = out_.joints[i];
            if (joint_to[joint.child] != k_none)
                xml_.refuse(joint_nodes_[i],
                            "link '" + out_.links[joint.child].name + "' is the child of joint '" +
                                out_.joints[joint_to[joint.child]].name + "' and of '" + joint.name + "'",
                            "a link has one parent: remove one of the joints");
            joint_to[joint.child] = i;
        }
        // Every path up ends at a link without a parent, or the joints on it form a circle.
        std::size_t root = k_none;
        for (std::size_t l = 0; l < out_.links.size(); ++l) {
            std::size_t at = l, steps = 0;
            for (; joint_to[at] != k_none; at = out_.joints[joint_to[at]].parent)
                if (++steps > out_.joints.size())
                    xml_.refuse(joint_nodes_[joint_to[l]],
                                "joint '" + out_.joints[joint_to[l]].name + "' is in a circle of joints, or below one",
                                "a robot is a tree: remove one of the joints");
            if (root == k_none) root = at;
            if (root != at) throw DescriptionError(xml_error_of(at, root));
        }
        out_.root = root;
    }
    [[nodiscard]] std::string xml_error_of(std::size_t link, std::size_t root) const
    {
        return file_line(out_.links[link].line) + "no joint leads to link '" + out_.links[link].name + "', nor to '" +
               out_.links[root].name + "'; a robot has one root: join one to the other";
    }
    [[nodiscard]] std::string file_line(std::size_t line) const { return xml_.file() + ':' + std::to_string(line) + ": "; }

    RobotXml xml_;
    Description out_;
    std::map<std::string, std::size_t> links_, joints_;
    std::vector<pugi::xml_node> joint_nodes_;
};

}  // namespace

Description read_description(std::string_view text, const std::string& file) { return Reader(text, file).run(); }

fs::path mesh_path(const std::string& filename, const fs::path& robot_file, const Packages& packages)
{
    constexpr std::string_view k_package = "package://", k_file = "file://";
    if (filename.starts_with(k_file)) return filename.substr(k_file.size());
    const fs::path folder = fs::absolute(robot_file).parent_path();
    if (!filename.starts_with(k_package)) return folder / filename;
    const std::string rest = filename.substr(k_package.size());
    const std::size_t slash = std::min(rest.find('/'), rest.size());
    const std::string name = rest.substr(0, slash);
    const fs::path below = slash < rest.size() ? rest.substr(slash + 1) : std::string();
    if (const auto found = packages.find(name); found != packages.end()) return found->second / below;
    for (fs::path up = folder;; up = up.parent_path()) {
        if (up.filename() == name) return up / below;
        if (fs::is_directory(up / name)) return up / name / below;
        if (up == up.parent_path()) return folder / name / below;
    }
}

}  // namespace sqmap::robot
