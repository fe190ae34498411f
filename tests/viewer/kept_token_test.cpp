#include "viewer/server/http/kept_token.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

namespace sqmap::viewer {
namespace {

namespace fs = std::filesystem;

/// A folder of this test alone, gone with it.
struct Folder {
    fs::path path = fs::temp_directory_path() / ("sqmap-token-" + std::to_string(::getpid()));
    ~Folder() { fs::remove_all(path); }
};

TEST(KeptToken, ARestartOnTheSamePortKeepsItAndAnotherPortHasAnother)
{
    const Folder folder;
    const std::string token = kept_token(folder.path, 4711);
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(kept_token(folder.path, 4711), token);
    EXPECT_NE(kept_token(folder.path, 4712), token);
    EXPECT_NE(kept_token(folder.path, 0), kept_token(folder.path, 0)) << "a port that anyone may get next";
    EXPECT_NE(kept_token({}, 4711), kept_token({}, 4711));
}

TEST(KeptToken, IsItsOwnersAloneAndElseMadeAnew)
{
    const Folder folder;
    const std::string token = kept_token(folder.path, 4711);
    const fs::path file = folder.path / "view-4711.token";
    const fs::perms owner = fs::perms::owner_read | fs::perms::owner_write;
    EXPECT_EQ(fs::status(file).permissions(), owner);
    fs::permissions(file, owner | fs::perms::others_read);
    const std::string second = kept_token(folder.path, 4711);
    EXPECT_NE(second, token);
    EXPECT_EQ(fs::status(file).permissions(), owner);
    // A file that is no token, too long, or a link is not taken.
    for (const std::string& text : {std::string("short"), second + "00", std::string(32, 'Z')}) {
        std::ofstream(file, std::ios::trunc) << text;
        const std::string fresh = kept_token(folder.path, 4711);
        EXPECT_EQ(fresh.size(), 32u);
        EXPECT_NE(fresh, text);
        EXPECT_EQ(fresh.find_first_not_of("0123456789abcdef"), std::string::npos);
    }
    fs::rename(file, folder.path / "elsewhere");
    fs::create_symlink(folder.path / "elsewhere", file);
    EXPECT_NE(kept_token(folder.path, 4711), second);
    EXPECT_FALSE(fs::is_symlink(file));
}

TEST(OpenInBrowser, GetsTheAddressInAFileOfItsOwner)
{
    const Folder folder;
    fs::create_directories(folder.path);
    const fs::path seen = folder.path / "seen", browser = folder.path / "xdg-open";
    std::ofstream(browser) << "#!/bin/sh\ncp \"$1\" " << seen.string() << ".part && mv " << seen.string() << ".part "
                           << seen.string() << "\n";
    fs::permissions(browser, fs::perms::owner_all);
    const std::string before = std::getenv("PATH");
    ::setenv("PATH", (folder.path.string() + ":" + before).c_str(), 1);
    EXPECT_TRUE(open_in_browser(folder.path, "http://127.0.0.1:4711/?token=0"));
    for (int i = 0; i < 1000 && !fs::exists(seen); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ::setenv("PATH", before.c_str(), 1);
    std::ifstream in(seen);
    const std::string page{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(page.find("url=http://127.0.0.1:4711/?token=0"), std::string::npos) << page;
    EXPECT_EQ(fs::status(folder.path / "open.html").permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_FALSE(open_in_browser({}, "http://127.0.0.1:4711/"));
}

}  // namespace
}  // namespace sqmap::viewer
