// The table of addresses.
#include "viewer/server/http/routes.h"

#include <gtest/gtest.h>

#include <string>

namespace sqmap::viewer {
namespace {

HttpReply reply_of(const Routes& routes, const std::string& method, const std::string& target)
{
    HttpReply reply;
    routes.serve({.method = method, .target = target, .body = {}}, [&](HttpReply r) { reply = std::move(r); });
    return reply;
}

Routes three_routes()
{
    Routes routes;
    for (const std::string name : {"app.js", "app.css"})  // patterns that are gone once they are added
        routes.get("/" + name, [name](const Call& call) { call.answer({.body = name}); });
    routes.get("/api/object/*/map/*",
               [](const Call& call) { call.answer({.body = std::string(call.stars[0]) + " " + std::string(call.stars[1])}); });
    routes.post("/api/upload", [](const Call& call) { call.answer({.body = "taken"}); });
    return routes;
}

TEST(Routes, AnswerWhatTheyWereAddedFor)
{
    const Routes routes = three_routes();
    EXPECT_EQ(reply_of(routes, "GET", "/app.js").body, "app.js");
    EXPECT_EQ(reply_of(routes, "GET", "/app.css").body, "app.css");
    EXPECT_EQ(reply_of(routes, "POST", "/api/upload?name=a.off").body, "taken");
}

TEST(Routes, HandOverWhatStandsForTheStars)
{
    EXPECT_EQ(reply_of(three_routes(), "GET", "/api/object/3/map/12?token=x").body, "3 12");
}

TEST(Routes, AnswerAllElseWith404)
{
    const Routes routes = three_routes();
    for (const char* target : {"/", "/app", "/app.js/", "/api/object/3/map", "/api/object/3/field/12", "/api/upload", ""})
        EXPECT_EQ(reply_of(routes, "GET", target).status, 404) << target;
    EXPECT_EQ(reply_of(routes, "POST", "/app.js").status, 404);
}

}  // namespace
}  // namespace sqmap::viewer
