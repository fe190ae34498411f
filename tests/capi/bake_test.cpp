// Bakes through the C interface: progress, units, and the texts of a model in the words of who asks.
#include "capi/fixture.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace sqmap {
namespace {

using test::Capi;
using test::expect_refused;
using test::GivenMesh;
using test::k_nan;

TEST_F(Capi, ProgressCancelsABake)
{
    const mesh::Mesh ball = mesh::sphere(1, 3);
    const GivenMesh given(ball);
    const sqmap_mesh in = given();
    int left = 3;
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.progress_context = &left;
    options.progress = [](void* context, const char*, double) { return --*static_cast<int*>(context) == 0 ? 1 : 0; };
    sqmap_model model{};
    expect_refused(sqmap_bake(&in, &options, &model), SQMAP_E_CANCELLED, "progress");
    EXPECT_EQ(left, 0);
    EXPECT_EQ(model.id, 0u);
}

TEST_F(Capi, AUnitMakesMetres)
{
    const GivenMesh given(torus_);
    const sqmap_mesh in = given();
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.unit = 0.001;
    sqmap_model model{};
    ASSERT_EQ(sqmap_bake(&in, &options, &model), SQMAP_OK) << sqmap_last_error()->message;
    sqmap_facts millimetres{}, metres{};
    millimetres.size = metres.size = sizeof metres;
    ASSERT_EQ(sqmap_model_facts(model_, &millimetres), SQMAP_OK);
    ASSERT_EQ(sqmap_model_facts(model, &metres), SQMAP_OK);
    EXPECT_NEAR(metres.r_max, 0.001 * millimetres.r_max, 1e-15);
    const Vec3d centre{0, 0, 0};
    const sqmap_points points{sizeof points, &centre.x, 1, nullptr};
    double distance = 0;
    sqmap_distances out{};
    out.size = sizeof out;
    out.distance = &distance;
    ASSERT_EQ(sqmap_exact_distances(model, &points, nullptr, &out), SQMAP_OK);
    double own = 0;
    out.distance = &own;
    ASSERT_EQ(sqmap_exact_distances(model_, &points, nullptr, &out), SQMAP_OK);
    EXPECT_NEAR(distance, 0.001 * own, 1e-15);
    EXPECT_EQ(sqmap_close_model(model), SQMAP_OK);
    for (const double unit : {-1.0, 1e-13, 1e13, k_nan}) {
        options.unit = unit;
        expect_refused(sqmap_bake(&in, &options, &model), SQMAP_E_ARGUMENT, "options.unit");
    }
}

TEST_F(Capi, TextsAreCutToTheirSpace)
{
    sqmap_text text{sizeof text, nullptr, 0, 0, 0};
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    ASSERT_GT(text.needed, 100u);
    std::string whole(text.needed, '#'), part(10, '#');
    text.text = whole.data();
    text.capacity = whole.size();
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    EXPECT_EQ(whole.find('\0'), whole.size() - 1);
    text.text = part.data();
    text.capacity = 5;
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    EXPECT_EQ(part.substr(0, 4), whole.substr(0, 4));
    EXPECT_EQ(part.substr(4), std::string("\0#####", 6));
}

TEST_F(Capi, NotesStandInTheFileInTheWordsOfWhoAsks)
{
    mesh::Mesh open = torus_;
    open.triangles.erase(open.triangles.begin() + 7);  // a hole that a cure closes, on a torus of 60 units
    for (Vec3d& v : open.vertices) v = 30.0 * v;
    const GivenMesh given(open);
    const sqmap_mesh in = given();
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.words = SQMAP_WORDS_PYTHON;
    sqmap_model baked{}, opened{};
    ASSERT_EQ(sqmap_bake(&in, &options, &baked), SQMAP_OK) << sqmap_last_error()->message;
    const void* bytes = nullptr;
    std::size_t size = 0;
    ASSERT_EQ(sqmap_bytes(baked, &bytes, &size), SQMAP_OK);
    ASSERT_EQ(sqmap_open_bytes(bytes, size, &opened), SQMAP_OK);
    const auto notes_of = [](sqmap_model model, std::int32_t words) {
        std::string out(4000, '\0');
        sqmap_text text{sizeof text, out.data(), out.size(), 0, words};
        EXPECT_EQ(sqmap_notes(model, &text), SQMAP_OK) << sqmap_last_error()->message;
        return std::string(out.c_str());
    };
    const std::string python = notes_of(baked, 0), c = notes_of(opened, 0);
    EXPECT_NE(python.find("made up: "), std::string::npos) << python;
    EXPECT_NE(python.find("(such as unit=\"mm\")"), std::string::npos) << python;
    EXPECT_NE(c.find("(such as unit = 0.001)"), std::string::npos) << c;
    EXPECT_EQ(notes_of(opened, SQMAP_WORDS_PYTHON), python);
    EXPECT_EQ(notes_of(opened, SQMAP_WORDS_JAVASCRIPT), notes_of(baked, SQMAP_WORDS_JAVASCRIPT));
    sqmap_facts facts{};
    facts.size = sizeof facts;
    ASSERT_EQ(sqmap_model_facts(opened, &facts), SQMAP_OK);
    EXPECT_EQ(facts.cure, 1);
    sqmap_text text{sizeof text, nullptr, 0, 0, 3};
    expect_refused(sqmap_notes(opened, &text), SQMAP_E_ARGUMENT, "lines.words");
    EXPECT_EQ(sqmap_close_model(baked), SQMAP_OK);
    EXPECT_EQ(sqmap_close_model(opened), SQMAP_OK);
}

TEST_F(Capi, ACureStandsInTheWordsOfWhoAsks)
{
    const GivenMesh given(torus_);
    const sqmap_mesh in = given();
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.without_exact = options.without_input = 1;
    sqmap_model bare{};
    ASSERT_EQ(sqmap_bake(&in, &options, &bare), SQMAP_OK) << sqmap_last_error()->message;
    expect_refused(sqmap_triangles(bare, nullptr, nullptr, nullptr), SQMAP_E_MISSING, "model");
    EXPECT_STREQ(sqmap_last_error()->cure, "bake it with the exact layer: without_exact = 0");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), "bake it with the exact layer: exact=True");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_JAVASCRIPT), "bake it with the exact layer: exact: true");
    expect_refused(sqmap_sources(bare, nullptr, nullptr), SQMAP_E_MISSING, "model");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_C), "bake it again with without_input = 0");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), "bake it again with keep_input=True");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_JAVASCRIPT), "bake it again with keepInput: true");
    for (const std::int32_t none : {-1, 3, 1 << 30}) EXPECT_STREQ(sqmap_last_cure(none), sqmap_last_error()->cure);
    EXPECT_EQ(sqmap_close_model(bare), SQMAP_OK);
    expect_refused(sqmap_close_model(bare), SQMAP_E_HANDLE, "model");  // a cure that names no setting is the same for all
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), sqmap_last_error()->cure);
}

}  // namespace
}  // namespace sqmap
