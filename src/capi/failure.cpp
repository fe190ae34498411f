#include "objects.h"
#include "structs.h"
#include "words.h"

#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"

#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>

namespace sqmap::capi {
namespace {

/// Fixed texts: an error is kept without memory from anywhere.
struct Kept {
    std::array<char, 64> name{};
    std::array<char, 768> element{}, message{};
    std::array<std::array<char, 768>, k_words> cures{};  ///< by sqmap_words
    sqmap_error error{sizeof(sqmap_error), SQMAP_OK, name.data(), element.data(), message.data(), cures[SQMAP_WORDS_C].data()};
};

thread_local Kept k_last;

struct Texts {
    const char *name, *element, *message;
};

const char* name_of(sqmap_code code)
{
    static constexpr std::array<const char*, 11> k_names{"OK",        "E_ARGUMENT", "E_HANDLE",  "E_FILE",
                                                         "E_MODEL",   "E_VERSION",  "E_MESH",    "E_CANCELLED",
                                                         "E_MISSING", "E_MEMORY",   "E_INTERNAL"};
    return k_names[static_cast<std::size_t>(code)];
}

template <std::size_t Size>
void put(std::array<char, Size>& to, const char* text)
{
    std::snprintf(to.data(), Size, "%s", text);
}

sqmap_code keep(sqmap_code code, const Texts& texts, const char* cure) noexcept
{
    put(k_last.name, texts.name == nullptr ? name_of(code) : texts.name);
    put(k_last.element, texts.element);
    put(k_last.message, texts.message);
    for (auto& kept : k_last.cures) put(kept, cure);
    k_last.error.cure = k_last.cures[SQMAP_WORDS_C].data();
    k_last.error.code = code;
    return code;
}

sqmap_code keep(const Failure& f)
{
    std::array<std::string, k_words> cures;
    for (std::size_t w = 0; w < k_words; ++w) cures[w] = f.cure.text(names_of(static_cast<std::int32_t>(w), "words"));
    keep(f.code, {f.name.empty() ? nullptr : f.name.c_str(), f.element.c_str(), f.message.c_str()}, "");
    for (std::size_t w = 0; w < k_words; ++w) put(k_last.cures[w], cures[w].c_str());
    k_last.error.cure = k_last.cures[static_cast<std::size_t>(f.words)].data();
    return f.code;
}

sqmap_code no_memory() noexcept
{
    return keep(SQMAP_E_MEMORY, {nullptr, "memory", "there is not enough of it"}, "take a smaller mesh or fewer points");
}

}  // namespace

void refuse_null(const char* element) { throw Failure{SQMAP_E_ARGUMENT, element, "is a null pointer", "give an address"}; }

void refuse_handle(std::uint64_t id, std::uint8_t kind, const char* element)
{
    static constexpr std::array<const char*, 7> k_kinds{"", "model", "probe", "workspace", "session", "pad", "pile"};
    const std::string wanted = k_kinds[kind];
    const std::uint64_t given = (id >> 16) & 0xff;
    if (id == 0) throw Failure{SQMAP_E_HANDLE, element, "is {0}", "give an open " + wanted};
    if (given != kind && given > 0 && given < k_kinds.size())
        throw Failure{SQMAP_E_HANDLE, element, std::string("is the handle of a ") + k_kinds[given], "give an open " + wanted};
    throw Failure{SQMAP_E_HANDLE, element, "is closed, or was never opened", "open it, and do not use it after closing it"};
}

sqmap_code caught() noexcept
{
    try {
        throw;
    } catch (const Failure& f) {
        try {
            return keep(f);
        } catch (...) {
            return no_memory();
        }
    } catch (const mesh::Error& e) {
        return keep(SQMAP_E_ARGUMENT, {nullptr, "options", e.what()}, "give a number within its range");
    } catch (const io::ModelFileError& e) {
        return keep(SQMAP_E_FILE, {nullptr, "path", e.what()}, "look at the folder, its rights and the space that is left");
    } catch (const std::bad_alloc&) {
        return no_memory();
    } catch (const std::exception& e) {
        return keep(SQMAP_E_INTERNAL, {nullptr, "sqmap", e.what()}, "report it with the call and its arguments");
    } catch (...) {
        return keep(SQMAP_E_INTERNAL, {nullptr, "sqmap", "an exception of unknown type"}, "report it with the call");
    }
}

}  // namespace sqmap::capi

const sqmap_error* sqmap_last_error(void) { return &sqmap::capi::k_last.error; }

const char* sqmap_last_cure(int32_t words)
{
    using namespace sqmap::capi;
    const bool is_known = words >= 0 && static_cast<std::size_t>(words) < k_words;
    return k_last.cures[is_known ? static_cast<std::size_t>(words) : std::size_t{SQMAP_WORDS_C}].data();
}
