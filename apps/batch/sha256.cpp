#include "batch/sha256.h"

#include <openssl/evp.h>

#include <array>
#include <stdexcept>

namespace sqmap::batch {

struct Sha256::Context {
    EVP_MD_CTX* of = EVP_MD_CTX_new();
    ~Context() { EVP_MD_CTX_free(of); }
};

namespace {

void check(int result)
{
    if (result != 1) throw std::runtime_error("SHA-256 cannot be computed: libcrypto refused");
}

}  // namespace

Sha256::Sha256() : context_(std::make_unique<Context>()) { check(EVP_DigestInit_ex(context_->of, EVP_sha256(), nullptr)); }
Sha256::~Sha256() = default;

void Sha256::add(std::string_view bytes) { check(EVP_DigestUpdate(context_->of, bytes.data(), bytes.size())); }

std::string Sha256::digest()
{
    std::array<unsigned char, 32> bytes{};
    check(EVP_DigestFinal_ex(context_->of, bytes.data(), nullptr));
    std::string out;
    for (const unsigned char b : bytes) {
        out += "0123456789abcdef"[b >> 4];
        out += "0123456789abcdef"[b & 15];
    }
    return out;
}

std::string sha256(std::string_view bytes)
{
    Sha256 hash;
    hash.add(bytes);
    return hash.digest();
}

}  // namespace sqmap::batch
