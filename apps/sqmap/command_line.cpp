#include "command_line.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>
#include <sstream>
#include <system_error>
#include <type_traits>

namespace sqmap::app {
namespace {

/// Help without the parser's own terms: what can be given, not how it is checked.
class PlainFormatter : public CLI::Formatter {
public:
    std::string make_option_opts(const CLI::Option* option) const override
    {
        std::string out;
        if (option->get_type_size() != 0) {
            out += ' ' + plain(option->get_type_name());
            if (!option->get_default_str().empty()) out += ", default " + option->get_default_str();
            if (option->get_expected_max() == CLI::detail::expected_max_vector_size) out += " ...";
            if (option->get_required()) out += " REQUIRED";
        }
        for (const CLI::Option* other : option->get_needs()) out += ", needs " + other->get_name();
        for (const CLI::Option* other : option->get_excludes()) out += ", not with " + other->get_name();
        return out;
    }

private:
    static std::string plain(std::string type)
    {
        static const std::pair<std::regex, const char*> k_rules[] = {{std::regex("TEXT:\\{(.*)\\}"), "$1"},  // one of a list
                                                                     {std::regex("TEXT:FILE"), "FILE"},
                                                                     {std::regex(":SIZE.*"), ""},
                                                                     {std::regex("(UINT|INT|FLOAT):RANGE:(.*)"), "$2"},
                                                                     {std::regex("(UINT|INT|FLOAT):POSITIVE"), "NUMBER > 0"},
                                                                     {std::regex("(UINT|INT|FLOAT):NONNEGATIVE"), "NUMBER >= 0"},
                                                                     {std::regex("^(UINT|INT|FLOAT)$"), "NUMBER"},
                                                                     {std::regex("^([A-Z]+):\\{(.*)\\}$"), "$2"}};
        for (const auto& [pattern, with] : k_rules) type = std::regex_replace(type, pattern, with);
        std::replace(type.begin(), type.end(), ',', '|');
        return type;
    }
};

struct Bound {
    const char *wanted, *name;
    bool (*allowed)(double);
    double max;
};

/// Finite numbers that `allowed` lets pass, up to a greatest. CLI11's own checks name the largest double, in full.
CLI::Validator bounded(const Bound& bound)
{
    return {[bound](std::string& text) {
                double value = 0;
                if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value) || !bound.allowed(value))
                    return std::string("must be a number ") + bound.wanted + " zero, not '" + text + "'";
                if (value <= bound.max) return std::string();
                std::ostringstream limit;
                limit << bound.max;
                return "is at most " + limit.str() + ", not " + text;
            },
            bound.name};
}

/// A file, or a folder where that may be: the words are those of all doors.
CLI::Validator existing(bool may_be_folder)
{
    return {[=](std::string& path) {
                std::error_code ignored;
                const std::filesystem::file_status status = std::filesystem::status(path, ignored);
                if (!std::filesystem::exists(status)) return path + ": " + io::k_no_file + " (" + io::k_no_file_cure + ")";
                const bool is_folder = std::filesystem::is_directory(status);
                return is_folder && !may_be_folder ? path + ": this is no file but a folder" : std::string();
            },
            may_be_folder ? "PATH(existing)" : "FILE"};
}

}  // namespace

// ---- Option

Option Option::required() { return Option(option_->required()); }
Option Option::existing_file() { return Option(option_->check(existing(false))); }
Option Option::existing_path() { return Option(option_->check(existing(true))); }
Option Option::one_of(std::vector<std::string> words) { return Option(option_->check(CLI::IsMember(std::move(words)))); }

/// CLI::Range lets NaN pass.
Option Option::in_range(double least, double max)
{
    std::ostringstream range;
    range << least << " to " << max;
    return Option(option_->check(CLI::Validator(
        [=, words = range.str()](std::string& text) {
            double value = 0;
            const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= max;
            return good ? std::string() : "must be a number from " + words + ", not '" + text + "'";
        },
        "RANGE:" + range.str())));
}

Option Option::above_zero(double max)
{
    return Option(option_->check(bounded({"above", "POSITIVE", [](double v) { return v > 0; }, max})));
}

Option Option::not_below_zero(double max)
{
    return Option(option_->check(bounded({"not below", "NONNEGATIVE", [](double v) { return v >= 0; }, max})));
}

Option Option::delimiter(char separator) { return Option(option_->delimiter(separator)); }
Option Option::excludes(Option other) { return option_->excludes(other.option_), *this; }
Option Option::needs(Option other) { return option_->needs(other.option_), *this; }
Option Option::type_name(const std::string& name) { return Option(option_->type_name(name)); }
Option Option::shows_default(const std::string& text) { return Option(option_->default_str(text)); }

// ---- Command

template <class Value>
Option Command::option(const std::string& name, Value& value, const std::string& words)
{
    CLI::Option* const option = command_->add_option(name, value, words)->group(title_);
    if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>) option->capture_default_str();
    return Option(option);
}
template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::uint16_t&, const std::string&);
template Option Command::option(const std::string&, std::uint32_t&, const std::string&);
template Option Command::option(const std::string&, std::uint64_t&, const std::string&);

/// CLI11's own check prints every unit that it knows.
Option Command::size(const std::string& name, std::uint64_t& bytes, const std::string& words)
{
    const auto transform = [](std::string& text) {
        static const std::regex k_size("([0-9]+(?:\\.[0-9]+)?) *([kmgt]?)i?b?", std::regex::icase);
        constexpr double k_max = 0x1p50;
        std::smatch match;
        if (std::regex_match(text, match, k_size)) {
            const std::size_t power = match.length(2) == 0 ? 0 : std::string("kmgt").find(CLI::detail::to_lower(match[2])) + 1;
            const double given = std::strtod(match.str(1).c_str(), nullptr) * std::pow(1024.0, power);
            if (given >= 1 && given <= k_max) return text = std::to_string(static_cast<std::uint64_t>(given)), std::string();
        }
        return "'" + text + "' is not a size: give 1 byte to 1024TB, as in 500MB or 4GB";
    };
    CLI::Option* const option = command_->add_option(name, bytes, words)->group(title_);
    return Option(
        option->transform(CLI::Validator(transform, ""))->type_name("SIZE")->default_str(std::to_string(bytes >> 30) + "GB"));
}

Option Command::flag(const std::string& name, bool& value, const std::string& words)
{
    return Option(command_->add_flag(name, value, words)->group(title_));
}

Option Command::text(const std::string& name, std::function<void(const std::string&)> take, const std::string& words)
{
    const auto checked = [take = std::move(take)](const std::string& text) {
        try {
            take(text);
        } catch (const WrongUsage& e) {
            throw CLI::ValidationError(e.option(), e.what());
        }
    };
    return Option(command_->add_option_function<std::string>(name, checked, words)->group(title_));
}

Option Command::vector(const std::string& name, Vec3d& value, const std::string& words)
{
    const auto take = [&value](const std::vector<double>& v) { value = {v[0], v[1], v[2]}; };
    CLI::Option* const option = command_->add_option_function<std::vector<double>>(name, take, words)->group(title_);
    return Option(option->delimiter('/')->expected(3)->type_name("X/Y/Z"));
}

Option Command::unit(const std::string& name, std::function<void(double)> take, const std::string& words)
{
    const auto read = [take = std::move(take), name](const std::string& text) {
        static const std::map<std::string, double> k_units{{"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},   {"dm", 0.1},
                                                           {"m", 1.0},   {"km", 1000.0}, {"in", 0.0254}, {"ft", 0.3048}};
        constexpr OptionRange k_range = option_named(mesh::k_admission_numbers, "unit").range;
        double value = 0;
        if (const auto known = k_units.find(text); known != k_units.end())
            value = known->second;
        else if (!CLI::detail::lexical_cast(text, value) || !k_range.holds(value))
            throw WrongUsage(name, "um, mm, cm, dm, m, km, in, ft or metres per unit");
        take(value);
    };
    return Command::text(name, read, words).type_name("UNIT");
}

void Command::footer(const std::string& text) { command_->footer(text); }

void Command::set_work(std::function<int()> work)
{
    command_->callback([work = std::move(work), command = command_] {
        if (!command->get_subcommands().empty()) return;
        int code = 0;
        try {
            code = work();
        } catch (const WrongUsage& e) {
            throw CLI::ValidationError(e.option(), e.what());
        }
        if (code != 0) throw CLI::RuntimeError(code);
    });
}

int Command::refused(const char* why)
{
    std::fprintf(stderr, "%s\n", why);
    return 2;
}

Command Command::add(const std::string& name, const std::string& description)
{
    return Command(command_->add_subcommand(name, description));
}

std::vector<std::string> Command::given_but(const std::vector<std::string>& left_out) const
{
    std::vector<std::string> out;
    for (const CLI::Option* option : command_->get_options()) {
        const std::string name = option->get_name();
        if (option->count() == 0 || option->get_positional() ||
            std::find(left_out.begin(), left_out.end(), name) != left_out.end())
            continue;
        const bool is_flag = option->get_expected_min() == 0;
        for (const std::string& value : option->results()) out.push_back(is_flag ? name : name + "=" + value);
    }
    return out;
}

bool Command::given(const std::string& option) const { return command_->count(option) > 0; }
std::string Command::lower(std::string text) { return CLI::detail::to_lower(std::move(text)); }

// ---- CommandLine

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : app_(std::make_unique<CLI::App>(description, name))
{
    app_->formatter(std::make_shared<PlainFormatter>());
    app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

void CommandLine::footer(const std::string& text) { app_->footer(text); }
void CommandLine::version(const std::string& text) { app_->set_version_flag("--version", text, "Print the version and exit"); }

Command CommandLine::add(const std::string& name, const std::string& description)
{
    return Command(app_->add_subcommand(name, description));
}

int CommandLine::run(int argc, char** argv)
{
    try {
        app_->parse(argc, argv);
    } catch (const CLI::RuntimeError& e) {
        return e.get_exit_code();  // of the subcommand
    } catch (const CLI::ParseError& e) {
        return app_->exit(e) == 0 ? 0 : 64;
    }
    return 0;
}

}  // namespace sqmap::app
