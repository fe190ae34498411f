#include "batch/text.h"

#include "sqmap/io/model_file.h"

#include <openssl/evp.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace sqmap::batch {

std::string sha256(std::string_view bytes)
{
    std::array<char, 32> digest{};
    if (EVP_Digest(bytes.data(), bytes.size(), reinterpret_cast<unsigned char*>(digest.data()), nullptr, EVP_sha256(), nullptr) !=
        1)
        throw std::runtime_error("SHA-256 cannot be computed: libcrypto refused");
    return hexadecimal({digest.data(), digest.size()});
}

std::string hexadecimal(std::string_view bytes)
{
    std::string out;
    for (const char c : bytes) {
        out += "0123456789abcdef"[static_cast<unsigned char>(c) >> 4];
        out += "0123456789abcdef"[static_cast<unsigned char>(c) & 15];
    }
    return out;
}

std::string base64(std::string_view bytes)
{
    std::string out((bytes.size() + 2) / 3 * 4 + 1, '\0');  // libcrypto ends the text with a zero byte
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                    static_cast<int>(bytes.size()));
    out.pop_back();
    return out;
}

std::string lower(std::string_view text)
{
    std::string out;
    for (const unsigned char c : text) out += static_cast<char>(std::tolower(c));
    return out;
}

std::string dumped(const nlohmann::ordered_json& json)
{
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string read_at(int file, std::uint64_t offset, std::uint64_t size)
{
    std::string out(size, '\0');
    for (std::size_t at = 0; at < size;) {
        const ssize_t n = ::pread(file, out.data() + at, size - at, static_cast<off_t>(offset + at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0)
            throw io::ModelFileError(std::string("cannot read a file: ") + (n < 0 ? std::strerror(errno) : "it ends early"));
        at += static_cast<std::size_t>(n);
    }
    return out;
}

}  // namespace sqmap::batch
