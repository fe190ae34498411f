// SHA-256, by which models are found and checked.
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace sqmap::batch {

class Sha256 {
public:
    Sha256();
    ~Sha256();
    Sha256(const Sha256&) = delete;
    Sha256& operator=(const Sha256&) = delete;

    void add(std::string_view bytes);
    /// The digest as 64 hexadecimal digits, once.
    [[nodiscard]] std::string digest();

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace sqmap::batch
