// Every subcommand registers itself on the parser; its callback does the work and returns the exit code through the
// exit_code reference (0 done, 1 replay found differences, 2 refused input, 64 usage, 70 internal).
#pragma once

#include <CLI/CLI.hpp>

#include <cmath>
#include <sstream>
#include <string>

namespace sqmap::app {

/// For check(): finite numbers that `allowed` lets pass, up to a greatest. CLI11's own say what they want with the largest
/// double, in full.
inline CLI::Validator number(const char* wanted, const char* name, bool (*allowed)(double), double most)
{
    return {[=](std::string& text) {
                double value = 0;
                if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value) || !allowed(value))
                    return std::string("must be a number ") + wanted + " zero, not '" + text + "'";
                if (value <= most) return std::string();
                std::ostringstream limit;
                limit << most;
                return "is at most " + limit.str() + ", not " + text;
            },
            name};
}
/// CLI::Range lets nan pass.
inline CLI::Validator in_range(double least, double most)
{
    std::ostringstream range;
    range << least << " to " << most;
    return {[=, words = range.str()](std::string& text) {
                double value = 0;
                const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
                return good ? std::string() : "must be a number from " + words + ", not '" + text + "'";
            },
            "RANGE:" + range.str()};
}
inline CLI::Validator above_zero(double most = INFINITY)
{
    return number(
        "above", "POSITIVE", [](double v) { return v > 0; }, most);
}
inline CLI::Validator not_below_zero(double most = INFINITY)
{
    return number(
        "not below", "NONNEGATIVE", [](double v) { return v >= 0; }, most);
}

void add_bake(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_devices(CLI::App& app, int& exit_code);
void add_dress(CLI::App& app, int& exit_code);  // where sqmap::sim is built
void add_eval(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_query(CLI::App& app, int& exit_code);
void add_render(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_rtcheck(CLI::App& app, int& exit_code);
void add_shapes(CLI::App& app, int& exit_code);
void add_touch(CLI::App& app, int& exit_code);
void add_view(CLI::App& app, int& exit_code);

}  // namespace sqmap::app
