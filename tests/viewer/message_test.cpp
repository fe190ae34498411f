#include "viewer/server/protocol/messages.h"

#include <gtest/gtest.h>

#include <string>

namespace sqmap::viewer {
namespace {

const std::string k_settings =
    R"({"say":"settings","layer":"exact","tolerance":0.0003,"paperForce":true,"proxy":false,"stiffness":700,"damping":0.5,"law":"paper",)"
    R"("friction":0.2,"fC":0.1,"kF":50,"texture":0.0001,"smoothing":0.001,)"
    R"("toolRadius":0.01,"zone":0,"forceLimit":1.5,"tool":3,"toolSize":0.1,"toolTurn":90,"toolTilt":-45})";

std::string replaced(std::string text, const std::string& what, const std::string& with)
{
    return text.replace(text.find(what), what.size(), with);
}

TEST(Message, ReadsATouch)
{
    const auto m = read_message(R"({"say":"touch","p":[0.1,-0.2,3],"held":true})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::Touch);
    EXPECT_EQ(m->target, (Vec3d{0.1, -0.2, 3}));
    EXPECT_TRUE(m->held);
}

TEST(Message, ReadsSettings)
{
    const auto m = read_message(k_settings);
    ASSERT_TRUE(m);
    EXPECT_EQ(m->settings, (Settings{.layer = query::Layer::Exact,
                                     .tolerance = 0.0003,
                                     .paper_force = true,
                                     .proxy = false,
                                     .stiffness = 700,
                                     .damping = 0.5,
                                     .law = Friction::Paper,
                                     .friction = 0.2,
                                     .f_c = 0.1,
                                     .k_f = 50,
                                     .texture = 0.0001,
                                     .smoothing = 0.001,
                                     .tool_radius = 0.01,
                                     .zone = 0,
                                     .force_limit = 1.5,
                                     .tool = ToolKind::Mesh,
                                     .tool_object = 3,
                                     .tool_size = 0.1,
                                     .tool_turn = 90,
                                     .tool_tilt = -45}));
}

TEST(Message, SettingsAreSaidAsTheyAreRead)
{
    auto m = read_message(k_settings);
    ASSERT_TRUE(m);
    EXPECT_FALSE(m->settings.edges) << "of a recording from before there were edges";
    m->settings.edges = true;
    nlohmann::ordered_json again = settings_json(m->settings);
    again["say"] = "settings";
    const auto read = read_message(again.dump());
    ASSERT_TRUE(read);
    EXPECT_EQ(read->settings, m->settings);
    // As many nearest steps as elsewhere.
    const OptionRange steps = option_named(paper::k_query_numbers, "nearest_steps").range;
    again["nearestSteps"] = static_cast<int>(steps.max);
    const auto max = read_message(again.dump());
    ASSERT_TRUE(max);
    EXPECT_EQ(max->settings.paper.nearest_steps, 100);
    again["nearestSteps"] = static_cast<int>(steps.max) + 1;
    EXPECT_FALSE(read_message(again.dump()));
    // The tool's settings name no layer; the library's default holds.
    m = read_message(replaced(k_settings, "exact", "tool"));
    ASSERT_TRUE(m);
    EXPECT_FALSE(m->settings.layer);
    EXPECT_EQ(Settings{}.stiffness, haptic::ZoneOptions{}.stiffness);
}

TEST(Message, ReadsEdits)
{
    const auto m = read_message(R"({"say":"merge","object":1,"part":2,"other":7})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::Merge);
    EXPECT_EQ(m->object, 1u);
    EXPECT_EQ(m->part, 2u);
    EXPECT_EQ(m->other, 7u);
    EXPECT_TRUE(read_message(R"({"say":"stop"})"));
    EXPECT_TRUE(read_message(R"({"say":"undo","object":0})"));
}

TEST(Message, ReadsMovedCutsNamesAndCloth)
{
    auto m = read_message(R"({"say":"movecut","object":1,"part":2,"other":7,"distance":0.004})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::MoveCut);
    EXPECT_EQ(m->distance, 0.004);
    m = read_message(R"({"say":"refit","object":1,"part":2})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->part, 2u);
    m = read_message(R"({"say":"name","object":0,"part":3,"name":"left foreleg"})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->name, "left foreleg");
    EXPECT_TRUE(read_message(R"({"say":"name","object":0,"part":3,"name":""})"));
    m = read_message(R"({"say":"fit","garment":"skirt","fabric":"silk","walks":true})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->garment, "skirt");
    EXPECT_TRUE(m->walks);
    m = read_message(R"({"say":"cloth","do":"grasp","p":[0,1.2,0.1]})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->handling, Handling::Grasp);
    EXPECT_EQ(m->target, (Vec3d{0, 1.2, 0.1}));
    m = read_message(R"({"say":"cloth","do":"sew","seam":1})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->handling, Handling::Sew);
    EXPECT_EQ(m->part, 1u);
    m = read_message(R"({"say":"cloth","do":"slit","line":[[7,0.2,0.1],[0,1,0]]})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->handling, Handling::Slit);
    EXPECT_EQ(m->line, (std::vector<ClothPoint>{{7, 0.2, 0.1}, {0, 1, 0}}));
    m = read_message(R"({"say":"record","on":true})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::Record);
    EXPECT_TRUE(m->held);
    EXPECT_TRUE(read_message(R"({"say":"cloth","do":"release"})"));
    EXPECT_TRUE(read_message(R"({"say":"undress"})"));
    for (const char* const wrong :
         {R"({"say":"movecut","object":1,"part":2,"other":2,"distance":0.004})",
          R"({"say":"movecut","object":1,"part":2,"other":3,"distance":-1})",
          R"({"say":"name","object":0,"part":3,"name":"a\nb"})", R"({"say":"name","object":0,"part":3,"name":7})",
          R"({"say":"fit","garment":"/etc/passwd","fabric":"silk","walks":true})",
          R"({"say":"fit","garment":"shirt","fabric":"steel","walks":true})", R"({"say":"cloth","do":"grasp"})",
          R"({"say":"record"})", R"({"say":"record","on":1})", R"({"say":"cloth","do":"slit","line":[[0,1,0]]})",
          R"({"say":"cloth","do":"slit","line":[[0,1,0],[0,1]]})", R"({"say":"cloth","do":"slit","line":[[0,1,0],[0,1,1.5]]})",
          R"({"say":"cloth","do":"slit","line":[[0,1,0],[-1,1,0]]})", R"({"say":"cloth","do":"slit","line":[[0,1,0],[0.5,1,0]]})",
          R"({"say":"cloth","do":"burn"})", R"({"say":"cloth","do":"cut","seam":-1})",
          R"({"say":"cloth","do":"drag","p":[0,0,1000]})"})
        EXPECT_FALSE(read_message(wrong)) << wrong;
    EXPECT_FALSE(read_message(R"({"say":"name","object":0,"part":3,"name":")" + std::string(61, 'x') + "\"}"));
    std::string line = R"({"say":"cloth","do":"slit","line":[[0,0,0])";
    for (std::size_t i = 0; i < k_max_line; ++i) line += ",[0,0,0]";
    EXPECT_FALSE(read_message(line + "]}")) << "a point too many";
    EXPECT_FALSE(read_message(replaced(k_settings, "\"tool\":3", "\"tool\":\"spear\"")));
    EXPECT_FALSE(read_message(replaced(k_settings, "\"tool\":3", "\"tool\":3,\"edges\":1")));
    EXPECT_FALSE(read_message(replaced(k_settings, "\"toolSize\":0.1", "\"toolSize\":3")));
}

TEST(Message, ReadsActsOnObjects)
{
    auto m = read_message(R"({"say":"hide","object":2,"on":true})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::Hide);
    EXPECT_EQ(m->object, 2u);
    EXPECT_TRUE(m->held);
    m = read_message(R"({"say":"move","object":1,"p":[0.1,0,-0.2]})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->target, (Vec3d{0.1, 0, -0.2}));
    m = read_message(R"({"say":"turn","object":0,"up":"z"})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->up, Up::Z);
    m = read_message(R"({"say":"rename","object":0,"name":"left hand"})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->name, "left hand");
    m = read_message(R"({"say":"restore"})");
    ASSERT_TRUE(m);
    EXPECT_EQ(m->say, Say::Restore);
    for (const char* const wrong :
         {R"({"say":"hide","object":2})", R"({"say":"hide","object":2,"on":1})", R"({"say":"move","object":1,"p":[0,0,1000]})",
          R"({"say":"move","object":1,"p":[0,0]})", R"({"say":"turn","object":0,"up":"w"})",
          R"({"say":"turn","object":0,"up":2})", R"({"say":"rename","object":0,"name":""})",
          R"({"say":"rename","object":0,"name":"a\nb"})", R"({"say":"restore","object":0})"})
        EXPECT_FALSE(read_message(wrong)) << wrong;
}

TEST(Message, RefusesWhatIsOutOfRange)
{
    for (const char* const wrong : {"-1", "2001", "1e999", "\"700\"", "null", "[700]", "NaN"})
        EXPECT_FALSE(read_message(replaced(k_settings, "700", wrong))) << wrong;
    EXPECT_FALSE(read_message(replaced(k_settings, "\"forceLimit\":1.5", "\"forceLimit\":0")));
    EXPECT_FALSE(read_message(replaced(k_settings, "exact", "1")));
    EXPECT_FALSE(read_message(replaced(k_settings, "\"law\":\"paper\"", "\"law\":\"viscous\"")));
    EXPECT_FALSE(read_message(replaced(k_settings, "\"kF\":50", "\"kF\":-1")));
    EXPECT_FALSE(read_message(R"({"say":"touch","p":[0,0,101],"held":true})"));
    EXPECT_FALSE(read_message(R"({"say":"touch","p":[0,0],"held":true})"));
    EXPECT_FALSE(read_message(R"({"say":"touch","p":[0,0,0],"held":1})"));
    EXPECT_FALSE(read_message(R"({"say":"split","object":-1,"part":0})"));
    EXPECT_FALSE(read_message(R"({"say":"split","object":0,"part":65536})"));
    EXPECT_FALSE(read_message(R"({"say":"split","object":0.5,"part":0})"));
    EXPECT_FALSE(read_message(R"({"say":"merge","object":0,"part":3,"other":3})"));
}

TEST(Message, RefusesWhatItDoesNotKnow)
{
    for (const char* const text :
         {"", "{", "[]", "null", "3", "\"touch\"", "{}", R"({"say":3})", R"({"say":"open","path":"/etc/passwd"})",
          R"({"say":"stop","more":1})", R"({"say":"undo"})", R"({"say":"stop"}{"say":"stop"})", "{\"say\":\"st\xff\xfeop\"}",
          R"({"say":"device","device":"trace:/etc/passwd"})"})
        EXPECT_FALSE(read_message(text)) << text;
    EXPECT_FALSE(read_message(std::string_view("{\"say\":\"stop\"}\0", 15)));
}

TEST(Message, RefusesDeepNestingWithoutDescending)
{
    const std::string deep = R"({"say":"stop","x":)" + std::string(30000, '[') + std::string(30000, ']') + "}";
    EXPECT_FALSE(read_message(deep));
    EXPECT_FALSE(read_message(std::string(60000, '[')));
}

TEST(Message, SurvivesEveryTruncationAndEveryWrongByte)
{
    for (std::size_t n = 0; n < k_settings.size(); ++n) EXPECT_FALSE(read_message(k_settings.substr(0, n)));
    for (std::size_t i = 0; i < k_settings.size(); ++i)
        for (const char c : {'\0', '"', '{', '[', '\\', '\x80', '-', 'e'}) {
            std::string text = k_settings;
            text[i] = c;
            if (const auto m = read_message(text)) {
                EXPECT_LE(m->settings.stiffness, 2000);
                EXPECT_GE(m->settings.force_limit, 0.1);
                EXPECT_LE(m->settings.force_limit, 3.3);
            }
        }
}

}  // namespace
}  // namespace sqmap::viewer
