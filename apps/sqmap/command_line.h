// The command line: subcommands, their options and the checks of them. CLI11 is behind it and compiled in one file, because its
// headers cost each source that includes them some ten seconds.
#pragma once

#include "common/program_words.h"
#include "sqmap/math/vec.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sqmap::app {

/// A subcommand was called wrongly: "OPTION: MESSAGE" is printed and the program ends with 64.
class WrongUsage : public std::runtime_error {
public:
    WrongUsage(std::string option, const std::string& message) : std::runtime_error(message), option_(std::move(option)) {}
    [[nodiscard]] const std::string& option() const { return option_; }

private:
    std::string option_;
};

/// A handle; each function changes the option and returns the handle.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}

    Option required();
    Option existing_file();
    /// A file or a folder.
    Option existing_path();
    /// Nothing but these words.
    Option one_of(std::vector<std::string> words);
    /// Numbers from least to most; NaN is refused.
    Option in_range(double least, double max);
    Option in_range(const OptionRange& range) { return in_range(range.least, range.max); }
    Option above_zero(double max = INFINITY);
    Option not_below_zero(double max = INFINITY);
    /// Between the values of one argument.
    Option delimiter(char separator);
    Option excludes(Option other);
    Option needs(Option other);
    /// The help's word for the kind of value.
    Option type_name(const std::string& name);
    /// The help says this of the default instead of the variable's value; an empty text: nothing.
    Option shows_default(const std::string& text);

private:
    CLI::Option* option_;
};

/// A subcommand; a handle. Variables and functions that it is given must outlive the parser.
class Command {
public:
    explicit Command(CLI::App* command, std::string title = "Options") : command_(command), title_(std::move(title)) {}

    /// The same subcommand; the help lists the options that this handle adds under a title.
    [[nodiscard]] Command titled(const std::string& title) const { return Command(command_, title); }

    /// Sets a variable: a number, a text, std::optional<double>, or a vector of texts. name: "--layer", "-o,--output", or without
    /// dashes for a positional argument. The help says the value that a number or a text has now. Instantiated in
    /// command_line.cpp for the types in use.
    template <class Value>
    Option option(const std::string& name, Value& value, const std::string& words);
    /// A number of a library's table, by its name and within its range: "max_parts" is "--max-parts".
    template <class Options>
    Option number(const NumberOption<Options>& number, Options& options, const std::string& words)
    {
        const auto add = [&]<class Number>(Number Options::*member) {
            return option(as_option(number.name), options.*member, words);
        };
        return std::visit(add, number.member).in_range(number.range);
    }
    /// Bytes, 1 to 1024TB; also with kB, MB, GB, TB, of 1024 each.
    Option size(const std::string& name, std::uint64_t& bytes, const std::string& words);
    Option flag(const std::string& name, bool& value, const std::string& words);
    /// Hands the text over. take: throws WrongUsage for a text that it does not take.
    Option text(const std::string& name, std::function<void(const std::string&)> take, const std::string& words);
    /// X/Y/Z
    Option vector(const std::string& name, Vec3d& value, const std::string& words);
    /// A length unit by its name, or metres per unit.
    Option unit(const std::string& name, std::function<void(double)> take, const std::string& words);
    /// One of the names, whatever their case. order: the names as the help lists them, "a|b|c".
    template <class Value>
    Option choice(const std::string& name, Value& value, const std::map<std::string, Value>& names, const char* words,
                  const std::string& order)
    {
        std::string now;
        for (const auto& [text, named] : names)
            if (named == value && now.empty()) now = text;  // "auto" before what it means
        const auto take = [&value, names, order, name](const std::string& text) {
            const auto found = names.find(lower(text));
            if (found == names.end()) throw WrongUsage(name, "'" + text + "' is none of " + order);
            value = found->second;
        };
        return text(name, take, words).type_name(order).shows_default(now);
    }

    /// A subcommand of this one; when it is given, this one's own work is not done.
    [[nodiscard]] Command add(const std::string& name, const std::string& description);
    /// The options that the user gave, as "--name=value" each, but for those that are left out; in the order of the help.
    [[nodiscard]] std::vector<std::string> given_but(const std::vector<std::string>& left_out) const;

    /// Below the options in the help.
    void footer(const std::string& text);
    /// Sets the subcommand's work, whose result is the program's exit code. Where it throws one of the Refusals, the program
    /// prints the exception's words on standard error and ends with 2.
    template <class... Refusals>
    void run(std::function<int()> work)
    {
        set_work([work = std::move(work)] { return or_refused<Refusals...>(work); });
    }
    /// The user gave this option.
    [[nodiscard]] bool given(const std::string& option) const;

private:
    static std::string lower(std::string text);
    void set_work(std::function<int()> work);
    template <class... None>
    requires(sizeof...(None) == 0) static int or_refused(const std::function<int()>& work) { return work(); }
    template <class Refusal, class... Others>
    static int or_refused(const std::function<int()>& work)
    {
        try {
            return or_refused<Others...>(work);
        } catch (const Refusal& e) {
            return refused(e.what());
        }
    }
    static int refused(const char* why);

    CLI::App* command_;
    std::string title_;
};

class CommandLine {
public:
    CommandLine(const std::string& description, const std::string& name);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    void footer(const std::string& text);
    void version(const std::string& text);
    [[nodiscard]] Command add(const std::string& name, const std::string& description);
    /// Runs the subcommand that the arguments name; its exit code, or 64 for wrong usage, which is told on standard error.
    [[nodiscard]] int run(int argc, char** argv);

private:
    std::unique_ptr<CLI::App> app_;
};

}  // namespace sqmap::app
