#include "sqmap/device/open.h"

#include "math/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::device {

std::string DeviceSpec::text(std::string_view name, std::string_view otherwise) const
{
    const auto at = std::find_if(options.begin(), options.end(), [&](const auto& o) { return o.first == name; });
    return at == options.end() ? std::string(otherwise) : at->second;
}

namespace {

double number_of(const std::string& value, const std::string& what, double min, double max, bool whole)
{
    double number = 0;
    const auto [end, error] = sqmap::from_chars(value.data(), value.data() + value.size(), number);
    if (error == std::errc() && end == value.data() + value.size() && number >= min && number <= max &&
        (!whole || number == std::floor(number)))
        return number;
    char limits[64];
    std::snprintf(limits, sizeof limits, "%g to %g", min, max);
    throw DeviceError(what + " must be a " + (whole ? "whole " : "") + "number from " + limits + ", found '" + value + "'");
}

}  // namespace

double DeviceSpec::number(std::string_view name, double otherwise, double min, double max) const
{
    for (const auto& [known, value] : options)
        if (known == name) return number_of(value, kind + ": " + known, min, max, false);
    return otherwise;
}

int DeviceSpec::whole(std::string_view name, int otherwise, int min, int max) const
{
    for (const auto& [known, value] : options)
        if (known == name) return static_cast<int>(number_of(value, kind + ": " + known, min, max, true));
    return otherwise;
}

int DeviceSpec::index(int otherwise, int min, int max) const
{
    return first.empty() ? otherwise : static_cast<int>(number_of(first, kind + ": the index", min, max, true));
}

void DeviceSpec::only_named() const
{
    if (!first.empty()) throw DeviceError(kind + " takes NAME=VALUE only, found '" + first + "'");
}

void DeviceSpec::allow(std::span<const std::string_view> names) const
{
    for (const auto& [name, value] : options) {
        if (std::find(names.begin(), names.end(), name) != names.end()) continue;
        std::string all;
        for (const std::string_view known : names) all += (all.empty() ? "" : ", ") + std::string(known);
        throw DeviceError(kind + " has no option '" + name + "'" + (all.empty() ? "" : "; it has " + all));
    }
}

DeviceSpec parse_spec(std::string_view text)
{
    DeviceSpec spec;
    const std::size_t colon = text.find(':');
    spec.kind = text.substr(0, colon);
    if (spec.kind.empty()) throw DeviceError("a device is KIND or KIND:ARGUMENTS, found '" + std::string(text) + "'");
    if (colon == std::string_view::npos) return spec;
    std::string_view rest = text.substr(colon + 1);
    for (bool first = true; !rest.empty(); first = false) {
        const std::string_view argument = rest.substr(0, rest.find(','));
        if (argument.empty() || argument.size() + 1 == rest.size())
            throw DeviceError(spec.kind + ": an argument is empty: a comma too many in '" + std::string(text) + "'");
        rest.remove_prefix(std::min(rest.size(), argument.size() + 1));
        const std::size_t equals = argument.find('=');
        if (equals == std::string_view::npos && first) {
            spec.first = argument;
        } else if (equals == std::string_view::npos || equals == 0) {
            throw DeviceError(spec.kind + ": expected NAME=VALUE, found '" + std::string(argument) + "'");
        } else {
            const std::string name(argument.substr(0, equals));
            for (const auto& [known, value] : spec.options)
                if (known == name) throw DeviceError(spec.kind + ": '" + name + "' is given twice");
            spec.options.emplace_back(name, argument.substr(equals + 1));
        }
    }
    return spec;
}

}  // namespace sqmap::device
