// XML of robot files.
#pragma once

#include "sqmap/math/vec.h"

#include <pugixml.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace sqmap::robot {

/// A file's document, and lines for its elements.
class RobotXml {
public:
    /// Parses; comments, white space and unknown elements are kept. @throw DescriptionError with the line
    RobotXml(std::string_view text, std::string file);

    /// The file with the changes that were made to its elements. White space around the robot's element is the file's.
    [[nodiscard]] std::string text() const;
    [[nodiscard]] pugi::xml_node robot() const { return document_.child("robot"); }
    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] std::size_t line_of(const pugi::xml_node& node) const;
    /// @throw DescriptionError "FILE:LINE: MESSAGE; CURE"
    [[noreturn]] void refuse(const pugi::xml_node& node, const std::string& message, const std::string& cure) const;
    /// A required attribute. @throw DescriptionError
    [[nodiscard]] std::string needed(const pugi::xml_node& node, const char* attribute) const;
    /// Numbers of an attribute, or those that stand for it where it is absent. @throw DescriptionError
    [[nodiscard]] Vec3d vector(const pugi::xml_node& node, const char* attribute, Vec3d absent) const;
    [[nodiscard]] double number(const pugi::xml_node& node, const char* attribute, double absent) const;

private:
    [[nodiscard]] std::size_t line_at(std::ptrdiff_t offset) const;
    /// An attribute's text, which must not be xacro's.
    [[nodiscard]] std::string expanded(const pugi::xml_node& node, const pugi::xml_attribute& attribute) const;
    [[noreturn]] void refuse_xacro(const pugi::xml_node& node, const std::string& found) const;

    std::string text_, file_;
    pugi::xml_document document_;
};

}  // namespace sqmap::robot
