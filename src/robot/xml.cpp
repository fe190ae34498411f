#include "robot/xml.h"

#include "math/number_text.h"
#include "sqmap/robot/description.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace sqmap::robot {
namespace {

/// Numbers between white space; false where something else stands there.
bool read_numbers(std::string_view text, double* values, std::size_t count)
{
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto skip = [&] {
        while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
    };
    for (std::size_t i = 0; i < count; ++i) {
        skip();
        if (at != end && *at == '+') ++at;
        const auto [next, error] = from_chars(at, end, values[i]);
        if (error != std::errc{} || !std::isfinite(values[i])) return false;
        at = next;
    }
    skip();
    return at == end;
}

}  // namespace

RobotXml::RobotXml(std::string_view text, std::string file) : text_(text), file_(std::move(file))
{
    const unsigned how = pugi::parse_full | pugi::parse_ws_pcdata;
    const pugi::xml_parse_result result = document_.load_buffer(text_.data(), text_.size(), how);
    if (!result)
        throw DescriptionError(file_ + ':' + std::to_string(line_at(result.offset)) +
                               ": this is no XML: " + result.description() + "; correct the file there");
    const pugi::xml_node root = document_.document_element();
    if (std::string_view(root.name()) != "robot")
        refuse(root, "the file's element is '" + std::string(root.name()) + "', not 'robot'", "give a URDF file");
    const auto is_xacro = [](const pugi::xml_node& node) { return std::string_view(node.name()).starts_with("xacro:"); };
    if (const pugi::xml_node found = root.find_node(is_xacro)) refuse_xacro(found, found.name());
}

void RobotXml::refuse_xacro(const pugi::xml_node& node, const std::string& found) const
{
    refuse(node, "this is a xacro file, whose macros are not expanded ('" + found + "')",
           "run 'xacro " + file_ + " > robot.urdf' and give that file");
}

std::string RobotXml::text() const
{
    std::ostringstream stream;
    const auto put = [&](const pugi::xml_node& node) { node.print(stream, "", pugi::format_raw, pugi::encoding_utf8); };
    // The parser drops white space outside the robot's element.
    const auto begin = static_cast<std::size_t>(robot().offset_debug());
    constexpr std::string_view k_name = "robot";
    if (begin > 0 && std::string_view(text_).substr(begin, k_name.size()) == k_name) {
        stream << std::string_view(text_).substr(0, begin - 1);
        put(robot());
    } else {
        for (const pugi::xml_node& node : document_.children()) {
            put(node);
            if (node == robot()) break;
            stream << '\n';
        }
    }
    for (pugi::xml_node node = robot().next_sibling(); node; node = node.next_sibling()) {
        stream << '\n';
        put(node);
    }
    return stream.str() + text_.substr(std::min(text_.size(), text_.find_last_not_of(" \t\r\n") + 1));
}

std::size_t RobotXml::line_at(std::ptrdiff_t offset) const
{
    const auto end = std::clamp<std::ptrdiff_t>(offset, 0, static_cast<std::ptrdiff_t>(text_.size()));
    return 1 + static_cast<std::size_t>(std::count(text_.begin(), text_.begin() + end, '\n'));
}

std::size_t RobotXml::line_of(const pugi::xml_node& node) const { return line_at(node.offset_debug()); }

void RobotXml::refuse(const pugi::xml_node& node, const std::string& message, const std::string& cure) const
{
    throw DescriptionError(file_ + ':' + std::to_string(line_of(node)) + ": " + message + "; " + cure);
}

std::string RobotXml::expanded(const pugi::xml_node& node, const pugi::xml_attribute& attribute) const
{
    std::string value = attribute.value();
    for (const char* mark : {"${", "$("})
        if (value.find(mark) != std::string::npos) refuse_xacro(node, value);
    return value;
}

std::string RobotXml::needed(const pugi::xml_node& node, const char* attribute) const
{
    const std::string value = expanded(node, node.attribute(attribute));
    if (value.empty())
        refuse(node, std::string("<") + node.name() + "> has no " + attribute, std::string("give it ") + attribute + "=\"...\"");
    return value;
}

Vec3d RobotXml::vector(const pugi::xml_node& node, const char* attribute, Vec3d absent) const
{
    const pugi::xml_attribute found = node.attribute(attribute);
    if (!found) return absent;
    double v[3] = {};
    if (!read_numbers(expanded(node, found), v, 3))
        refuse(node, std::string(attribute) + "=\"" + found.value() + "\" is not three numbers", "write it as \"x y z\"");
    return {v[0], v[1], v[2]};
}

double RobotXml::number(const pugi::xml_node& node, const char* attribute, double absent) const
{
    const pugi::xml_attribute found = node.attribute(attribute);
    if (!found) return absent;
    double v = 0;
    if (!read_numbers(expanded(node, found), &v, 1))
        refuse(node, std::string(attribute) + "=\"" + found.value() + "\" is not a number", "write a number");
    return v;
}

}  // namespace sqmap::robot
