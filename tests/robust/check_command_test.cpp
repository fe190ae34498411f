// The program itself: exit codes and the JSON answer of `sqmap check`.
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

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
        folder_ = std::filesystem::temp_directory_path() / ("sqmap_check_" + std::to_string(::getpid()) + "_" +
                                                            testing::UnitTest::GetInstance()->current_test_info()->name());
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

TEST_F(CheckCommand, SaysOfAFolderWhatBecameOfEachFile)
{
    const std::string folder = std::filesystem::path(file("good.obj", k_good)).parent_path().string() + "/many";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder + "/below");
    std::filesystem::copy(file("good.obj", k_good), folder + "/below/good.obj");
    std::filesystem::copy(file("bad.obj", "v 0 0 0\nf 1 2 3\n"), folder + "/bad.obj");
    std::filesystem::copy(file("notes.txt", "no mesh"), folder + "/notes.txt");
    const Answer table = run("check " + folder);
    EXPECT_EQ(table.exit_code, 2);
    EXPECT_NE(table.text.find("REFUSED"), std::string::npos) << table.text;
    EXPECT_NE(table.text.find("E_INDEX"), std::string::npos) << table.text;
    EXPECT_NE(table.text.find("2 files: ACCEPT 1 REFUSED 1"), std::string::npos) << table.text;
    const Answer lines = run("check " + folder + " --json");
    std::istringstream in(lines.text);
    std::vector<std::string> verdicts;
    for (std::string line; std::getline(in, line);) verdicts.push_back(nlohmann::json::parse(line)["verdict"]);
    EXPECT_EQ(verdicts, (std::vector<std::string>{"REFUSED", "ACCEPT"}));
}

TEST_F(CheckCommand, RefusesWithCodeElementAndCure)
{
    const std::string open = file("open.obj", k_vertices + "f 1 3 2\nf 1 2 4\nf 2 3 4\n");
    const nlohmann::json answer = json(open + " --repair safe", 2);
    EXPECT_EQ(answer["verdict"], "REFUSED");
    EXPECT_EQ(answer["code"], "E_OPEN");
    EXPECT_TRUE(answer["element"].get<std::string>().starts_with("edge "));
    EXPECT_FALSE(answer["cure"].get<std::string>().empty());
    EXPECT_EQ(json(open + " --surface", 0)["facts"]["solid"], false);
    EXPECT_EQ(json(open + " --thickness 1", 0)["facts"]["solid"], true);
    const Answer text = run("check " + open + " --repair safe");
    EXPECT_EQ(text.exit_code, 2);
    EXPECT_NE(text.text.find("E_OPEN"), std::string::npos);
}

TEST_F(CheckCommand, LimitsAreRaisedAndLoweredByFlags)
{
    const std::string good = file("good.obj", k_good);
    for (const std::string limit : {"--max-bytes 20", "--max-faces 3", "--max-components 1"}) {
        // Two pieces for the last of them.
        const std::string mesh = limit.find("components") == std::string::npos
                                     ? good
                                     : file("two.obj", k_good +
                                                           "v 200 0 0\nv 300 0 0\nv 200 100 0\nv 200 0 100\n"
                                                           "f 5 7 6\nf 5 6 8\nf 6 7 8\nf 5 8 7\n");
        EXPECT_EQ(json(mesh, 0)["verdict"], "ACCEPT");
        const nlohmann::json answer = json(mesh + " " + limit, 2);
        EXPECT_EQ(answer["code"], "E_LIMIT") << limit;
        const std::string flag = limit.substr(0, limit.find(' '));
        EXPECT_NE(answer["cure"].get<std::string>().find(flag), std::string::npos) << "the cure names the flag " << flag;
        EXPECT_EQ(json(mesh + " " + flag + " 4000", 0)["verdict"], "ACCEPT");
        // bake takes the same flags, and leaves no model behind.
        const std::string model = (folder_ / "model.sqmap").string();
        EXPECT_EQ(run("bake " + mesh + " -o " + model + " " + limit).exit_code, 2) << limit;
        EXPECT_FALSE(std::filesystem::exists(model));
    }
    EXPECT_EQ(json(good + " --max-bytes 1KB", 0)["verdict"], "ACCEPT");
    EXPECT_EQ(run("check " + good + " --max-faces 0").exit_code, 64);
    EXPECT_EQ(run("check " + good + " --max-bytes much").exit_code, 64);
}

TEST_F(CheckCommand, AThousandPiecesAreTheMostByDefault)
{
    const auto pieces = [&](int count) {
        std::string text;
        for (int i = 0; i < count; ++i) {
            const int x = 2 * (i % 32), y = 2 * (i / 32), v = 4 * i;
            const auto at = [&](int a, int b, int c) {
                text += "v " + std::to_string(x + a) + " " + std::to_string(y + b) + " " + std::to_string(c) + "\n";
            };
            at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1);
            for (const auto& f : {std::array{1, 3, 2}, {1, 2, 4}, {2, 3, 4}, {1, 4, 3}})
                text += "f " + std::to_string(v + f[0]) + " " + std::to_string(v + f[1]) + " " + std::to_string(v + f[2]) + "\n";
        }
        return file("pieces.obj", text);
    };
    EXPECT_EQ(json(pieces(1000), 0)["facts"]["components"], 1000);
    EXPECT_EQ(json(pieces(1001), 2)["code"], "E_LIMIT");
    EXPECT_EQ(json(pieces(1001) + " --max-components 1001", 0)["facts"]["components"], 1001);
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
