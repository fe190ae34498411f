#include "commands.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <memory>
#include <regex>
#include <string>
#include <utility>

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
        static const std::pair<std::regex, const char*> k_rules[] = {{std::regex(":value in .*"), ""},  // a|b|c is said already
                                                                     {std::regex("->[^,}]*"), ""},      // {cm->0.01,m->1}
                                                                     {std::regex("TEXT:\\{(.*)\\}"), "$1"},  // one of a list
                                                                     {std::regex("FLOAT:\\{(.*)\\}.*"), "$1"},
                                                                     {std::regex("TEXT:FILE"), "FILE"},
                                                                     {std::regex("TEXT:DIR"), "FOLDER"},
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

}  // namespace

int main(int argc, char** argv)
{
    // A file that may grow no further is a failed write, which removes what was written, not a reason to die halfway.
    std::signal(SIGXFSZ, SIG_IGN);
    CLI::App app{"sqmap: certified contact between complex shapes", "sqmap"};
    app.formatter(std::make_shared<PlainFormatter>());
    app.footer(
        "To begin with: sqmap check MESH, sqmap bake MESH -o MODEL.sqmap, sqmap view MODEL.sqmap.\n"
        "Each subcommand explains itself: sqmap bake --help.");
    app.set_version_flag("--version", "sqmap " SQMAP_VERSION, "Print the version and exit");
    app.require_subcommand(1);
    int exit_code = 0;
    sqmap::app::add_check(app, exit_code);
    sqmap::app::add_bake(app, exit_code);
    sqmap::app::add_info(app, exit_code);
    sqmap::app::add_query(app, exit_code);
    sqmap::app::add_eval(app, exit_code);
    sqmap::app::add_render(app, exit_code);
    sqmap::app::add_rtcheck(app, exit_code);
    sqmap::app::add_shapes(app, exit_code);
    sqmap::app::add_touch(app, exit_code);
    sqmap::app::add_replay(app, exit_code);
    sqmap::app::add_devices(app, exit_code);
#ifdef SQMAP_WITH_SIM
    sqmap::app::add_dress(app, exit_code);
#endif
    sqmap::app::add_view(app, exit_code);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 64;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "sqmap: internal error: %s\n", e.what());
        return 70;
    }
    return exit_code;
}
