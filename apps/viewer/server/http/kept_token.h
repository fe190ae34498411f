// A token that a restart on the same port keeps, so that pages that were open find the program again, and a way to open one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace sqmap::viewer {

/// The folder that keeps both: sqmap in XDG_STATE_HOME or in ~/.local/state; empty where there is neither.
[[nodiscard]] std::filesystem::path state_folder();

/// The token of a port, from a file of the folder that only its owner can read; made where there is none, where others could
/// read it or where it is no token. Port 0, which any program may get, or no folder: a new one.
/// @throw std::system_error where the kernel gives no random numbers
[[nodiscard]] std::string kept_token(const std::filesystem::path& folder, std::uint16_t port);

/// Opens the address in the user's browser, by a file that only they can read: a command line would show the token to all. False
/// where that cannot be done.
bool open_in_browser(const std::filesystem::path& folder, const std::string& url);

}  // namespace sqmap::viewer
