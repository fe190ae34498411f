// The program itself: exit codes and the JSON answer of `sqmap check`.
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/wait.h>

namespace {

struct Answer {
    int exit_code = -1;
    std::string text;
};

Answer run(const std::string& arguments)
{
    Answer answer;
    FILE* pipe = popen((std::string(SQMAP_PROGRAM) + " " + arguments + " 2>/dev/null").c_str(), "r");
    if (pipe == nullptr) return answer;
    std::array<char, 4096> buffer{};
    for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) answer.text.append(buffer.data(), n);
    const int status = pclose(pipe);
    answer.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return answer;
}

class CheckCommand : public testing::Test {
protected:
    void SetUp() override
    {
        // One folder for each test of each run: they may run at the same time.
        folder_ = std::filesystem::temp_directory_path() /
                  ("sqmap_check_" + std::to_string(::getpid()) + "_" + testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string file(const std::string& name, const std::string& text) const
    {
        std::ofstream(folder_ / name) << text;
        return (folder_ / name).string();
    }
    nlohmann::json json(const std::string& arguments, int exit_code) const
    {
        const Answer answer = run("check --json " + arguments);
        EXPECT_EQ(answer.exit_code, exit_code) << arguments;
        const nlohmann::json parsed = nlohmann::json::parse(answer.text, nullptr, false);
        EXPECT_TRUE(parsed.is_object()) << answer.text;
        return parsed;
    }

    std::filesystem::path folder_;
    const std::string k_vertices = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\n";
    const std::string k_good = k_vertices + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
};

TEST_F(CheckCommand, AcceptsWithFacts)
{
    const nlohmann::json answer = json(file("good.obj", k_good) + " --unit cm", 0);
    EXPECT_EQ(answer["verdict"], "ACCEPT");
    EXPECT_TRUE(answer["code"].is_null());
    EXPECT_TRUE(answer["repairs"].empty());
    EXPECT_TRUE(answer["warnings"].empty());
    EXPECT_NEAR(answer["facts"]["volume"].get<double>(), 1.0 / 6, 1e-12);
    EXPECT_EQ(json(file("good.obj", k_good), 0)["warnings"][0]["code"], "W_UNIT");
}

TEST_F(CheckCommand, NamesRepairsAndForbidsThemOnRequest)
{
    const std::string path = file("flipped.obj", k_vertices + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n");
    const nlohmann::json answer = json(path, 0);
    EXPECT_EQ(answer["verdict"], "REPAIRED");
    EXPECT_EQ(answer["repairs"][0]["kind"], "flipped");
    EXPECT_EQ(answer["repairs"][0]["count"], 4);
    EXPECT_EQ(json(path + " --repair none", 2)["code"], "E_ORIENT");
}

TEST_F(CheckCommand, RefusesWithCodeElementAndCure)
{
    const std::string open = file("open.obj", k_vertices + "f 1 3 2\nf 1 2 4\nf 2 3 4\n");
    const nlohmann::json answer = json(open, 2);
    EXPECT_EQ(answer["verdict"], "REFUSED");
    EXPECT_EQ(answer["code"], "E_OPEN");
    EXPECT_TRUE(answer["element"].get<std::string>().starts_with("edge "));
    EXPECT_FALSE(answer["cure"].get<std::string>().empty());
    EXPECT_EQ(json(open + " --surface", 0)["facts"]["solid"], false);
    EXPECT_EQ(json(open + " --thickness 1", 0)["facts"]["solid"], true);
    const Answer text = run("check " + open);
    EXPECT_EQ(text.exit_code, 2);
    EXPECT_NE(text.text.find("E_OPEN"), std::string::npos);
}

TEST_F(CheckCommand, WrongUsageIs64)
{
    const std::string good = file("good.obj", k_good);
    EXPECT_EQ(run("check").exit_code, 64);
    EXPECT_EQ(run("check " + (folder_ / "absent.obj").string()).exit_code, 64);
    EXPECT_EQ(run("check " + good + " --repair everything").exit_code, 64);
    EXPECT_EQ(run("check " + good + " --unit parsec").exit_code, 64);
    EXPECT_EQ(run("check " + good + " --thickness -1").exit_code, 64);
    EXPECT_EQ(run("check --help").exit_code, 0);
}

}  // namespace
