// Settings as doors have them: words that name them, the ranges of those that are numbers, those that change nothing. Meshes and
// models come in through C++, C, Python, JavaScript, the program or the page, and each of these doors writes the same setting its
// own way: it gives its table of names when it asks for the words, and takes ranges from here.
// Plain data and pure functions: any number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace sqmap {

/// An option that was changed and changes nothing: its name, the reason and the cure. The rules stand beside the options; each
/// door refuses or warns with the option's name as it has it.
struct IdleOption {
    const char* name;  ///< as in C and Python: "nearest_steps"
    const char* why;   ///< after the name: "counts with ..."
    const char* cure;  ///< an imperative, with other options' names in quotes: "set 'layer' to gate"
};

/// The least and the greatest value of an option; NaN is never held.
struct OptionRange {
    double least, max;
    /// True within the range, its ends included.
    [[nodiscard]] constexpr bool holds(double value) const noexcept { return value >= least && value <= max; }
};

/// "from 0.001 to 100". @throw std::bad_alloc
[[nodiscard]] std::string words(const OptionRange& range);

/// A member that is a number. Of an optional one that is absent the value is 0.
template <class Options>
using NumberMember = std::variant<double Options::*, int Options::*, std::uint32_t Options::*, std::uint64_t Options::*,
                                  std::optional<double> Options::*>;
/// Its value.
template <class Options>
[[nodiscard]] constexpr double value_of(const Options& options, const NumberMember<Options>& member)
{
    const auto read = [&]<class Number>(Number Options::*m) {
        if constexpr (std::is_same_v<Number, std::optional<double>>)
            return options.*m ? *(options.*m) : 0.;
        else
            return static_cast<double>(options.*m);
    };
    return std::visit(read, member);
}

/// A member of a struct of options that is a number with a range, for the library that checks it and for all doors that set it.
/// A table of them stands beside the struct.
template <class Options>
struct NumberOption {
    const char* name;  ///< in C, Python and messages of C++; others write it their own way: "--max-parts", "maxParts"
    NumberMember<Options> member;
    OptionRange range;

    [[nodiscard]] constexpr double value(const Options& options) const { return value_of(options, member); }  ///< as it is
    /// True where it is absent, or in its range.
    [[nodiscard]] constexpr bool fits(const Options& options) const
    {
        const auto* const optional = std::get_if<std::optional<double> Options::*>(&member);
        return (optional != nullptr && !(options.**optional)) || range.holds(value(options));
    }
    /// Sets it, whatever the range.
    constexpr void set(Options& options, double value) const
    {
        const auto write = [&]<class Number>(Number Options::*m) {
            if constexpr (std::is_same_v<Number, std::optional<double>>)
                options.*m = value;
            else
                options.*m = static_cast<Number>(value);
        };
        std::visit(write, member);
    }
};

/// @throw std::out_of_range always; elsewhere than here, for code that is compiled without exceptions
[[noreturn]] void refuse_option_name();

/// The one of a name in a table. @throw std::out_of_range where there is none, which a constant expression cannot
template <class Options, std::size_t n>
[[nodiscard]] constexpr const NumberOption<Options>& option_named(const NumberOption<Options> (&table)[n], std::string_view name)
{
    for (const NumberOption<Options>& option : table)
        if (option.name == name) return option;
    refuse_option_name();
}

/// The first of a table that is out of its range, in words: "max_parts must be from 1 to 1000"; empty where all are within.
template <class Options, std::size_t n>
[[nodiscard]] std::string out_of_range(const NumberOption<Options> (&table)[n], const Options& options)
{
    for (const NumberOption<Options>& option : table)
        if (!option.fits(options)) return std::string(option.name) + " must be " + words(option.range);
    return {};
}

}  // namespace sqmap

namespace sqmap::mesh {

/// A setting, or a call, that words can name.
enum class Setting : std::uint8_t {
    Repair,
    MaxFilled,
    Surface,
    Thickness,
    PlateThickness,  ///< the same, for a reader who has yet to bake
    Unit,
    MaxBytes,
    MaxFaces,
    MaxComponents,
    MaxCuredFaces,
    MaxWrappedFaces,
    WrapTolerance,
    MaxCells,
    MaxParts,
    TargetError,
    Exact,
    KeepInput,
    Packages,
    SolidProbe,  ///< a probe with triangles
    Bake,
    BakedMesh,  ///< the mesh that a model was baked from
};
/// Number of settings.
inline constexpr std::size_t k_settings = static_cast<std::size_t>(Setting::BakedMesh) + 1;

/// A door's name of a setting.
struct SettingName {
    Setting setting;
    const char* name;
};

/// How one door writes its settings.
class SettingNames {
public:
    /// A value as the door writes it; word: "close", "mm", "T" for a length that the reader has to choose.
    using Value = std::string (*)(Setting setting, std::string_view word);

    /// given: the settings that the door has. equals: between a name and a value. writes: null for the word itself.
    constexpr SettingNames(std::initializer_list<SettingName> given, const char* equals, Value writes = nullptr)
        : equals_(equals), value_(writes)
    {
        for (const SettingName& s : given) names_[static_cast<std::size_t>(s.setting)] = s.name;
    }
    /// The door's name of a setting; null where the door has no such setting.
    [[nodiscard]] const char* name(Setting setting) const { return names_[static_cast<std::size_t>(setting)]; }
    /// Between a name and a value.
    [[nodiscard]] const char* equals() const { return equals_; }
    /// The word as the door writes it.
    [[nodiscard]] std::string value(Setting setting, std::string_view word) const
    {
        return value_ == nullptr ? std::string(word) : value_(setting, word);
    }

private:
    std::array<const char*, k_settings> names_{};
    const char* equals_;
    Value value_;
};

/// The names of C++: AdmitOptions::repair = Repair::Close.
extern const SettingNames k_cpp_settings;

/// Text in which some clauses name a setting. A door that lacks the setting leaves its clause out.
class Words {
public:
    Words() = default;
    /// One clause that names no setting.
    Words(std::string text) { clauses_.push_back({std::move(text), {}, {}, {}}); }  // NOLINT(google-explicit-constructor)
    /// One clause that names no setting.
    Words(const char* text) : Words(std::string(text)) {}  // NOLINT(google-explicit-constructor)
    /// Begins with a clause that names a setting.
    Words(std::string before, Setting setting, std::string value = "", std::string after = "")
    {
        with(std::move(before), setting, std::move(value), std::move(after));
    }

    /// Adds a clause: before, the setting with its value ("close", or "close or wrap"; empty for the name alone), after.
    Words& with(std::string before, Setting setting, std::string value = "", std::string after = "")
    {
        clauses_.push_back({std::move(before), setting, std::move(value), std::move(after)});
        return *this;
    }
    Words& operator+=(const Words& more)
    {
        clauses_.insert(clauses_.end(), more.clauses_.begin(), more.clauses_.end());
        return *this;
    }
    friend Words operator+(Words a, const Words& b) { return a += b; }

    /// True without clauses.
    [[nodiscard]] bool empty() const { return clauses_.empty(); }
    /// Empty where there are no clauses, or none that the door has settings for.
    [[nodiscard]] std::string text(const SettingNames& names = k_cpp_settings) const;

private:
    struct Clause {
        std::string before;
        std::optional<Setting> setting;
        std::string value, after;
    };
    std::vector<Clause> clauses_;
};

}  // namespace sqmap::mesh
