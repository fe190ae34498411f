#include "viewer/server/http/request_check.h"

#include <gtest/gtest.h>

namespace sqmap::viewer {
namespace {

const Guard k_guard{"0123456789abcdef0123456789abcdef", 4711};

RequestHead page_request()
{
    return {.method = "GET", .target = "/?token=0123456789abcdef0123456789abcdef", .host = "127.0.0.1:4711", .origin = ""};
}

TEST(RequestCheck, GrantsThePrintedAddress) { EXPECT_EQ(admit(page_request(), k_guard), Admission::Granted); }

TEST(RequestCheck, KnowsThisMachineByItsThreeNames)
{
    RequestHead head = page_request();
    for (const char* const host : {"127.0.0.1:4711", "localhost:4711", "[::1]:4711"}) {
        head.host = host;
        EXPECT_EQ(admit(head, k_guard), Admission::Granted) << host;
    }
}

TEST(RequestCheck, RefusesEveryOtherHost)
{
    RequestHead head = page_request();
    for (const char* const host :
         {"", "evil.example:4711", "127.0.0.1", "127.0.0.1:4712", "127.0.0.1:04711", "127.0.0.1:4711x", "127.0.0.1:4711 ",
          "localhost.evil.example:4711", "127.0.0.1.evil.example:4711", "localhost:", "0.0.0.0:4711", "LOCALHOST:4711",
          "127.0.0.1:70247", "127.0.0.1:4711:4711", "@localhost:4711"}) {
        head.host = host;
        EXPECT_EQ(admit(head, k_guard), Admission::BadHost) << host;
    }
}

TEST(RequestCheck, RefusesEveryOtherOrigin)
{
    RequestHead head = page_request();
    head.has_origin = true;
    for (const char* const origin :
         {"", "null", "http://evil.example", "https://127.0.0.1:4711", "http://127.0.0.1:4712",
          "http://127.0.0.1:4711.evil.example", "http://127.0.0.1:4711/", "file://", "127.0.0.1:4711"}) {
        head.origin = origin;
        EXPECT_EQ(admit(head, k_guard), Admission::BadOrigin) << origin;
    }
    head.origin = "http://localhost:4711";
    EXPECT_EQ(admit(head, k_guard), Admission::Granted);
}

TEST(RequestCheck, WantsAnOriginForWhateverActs)
{
    RequestHead head = page_request();
    head.upgrade = true;
    EXPECT_EQ(admit(head, k_guard), Admission::BadOrigin);
    head = page_request();
    head.method = "POST";
    EXPECT_EQ(admit(head, k_guard), Admission::BadOrigin);
    head.has_origin = true;
    head.origin = "http://127.0.0.1:4711";
    EXPECT_EQ(admit(head, k_guard), Admission::Granted);
}

TEST(RequestCheck, TakesNamesOfFilesAsAPageWritesThem)
{
    // encodeURIComponent leaves these as they are, and some file is called so.
    RequestHead head = page_request();
    head.target = "/api/upload?name=my%20model%20(1)!'*~.obj&token=0123456789abcdef0123456789abcdef";
    EXPECT_EQ(admit(head, k_guard), Admission::Granted);
}

TEST(RequestCheck, WantsTheWholeTokenEverywhereButForTheFilesOfThePage)
{
    RequestHead head = page_request();
    for (const char* const target :
         {"/", "/?token=", "/?token=0123456789abcdef0123456789abcdee", "/?token=0123456789abcdef",
          "/?token=0123456789abcdef0123456789abcdef0", "/?Token=0123456789abcdef0123456789abcdef", "/ws", "/api/object/0/mesh",
          "/?xtoken=0123456789abcdef0123456789abcdef", "/app.js/x", "/app.jsx"}) {
        head.target = target;
        EXPECT_EQ(admit(head, k_guard), Admission::BadToken) << target;
    }
    for (const char* const target : {"/app.js", "/app.css", "/favicon.svg", "/ws?token=0123456789abcdef0123456789abcdef",
                                     "/x?a=b&token=0123456789abcdef0123456789abcdef"}) {
        head.target = target;
        EXPECT_EQ(admit(head, k_guard), Admission::Granted) << target;
    }
}

TEST(RequestCheck, RefusesATokenThatWasNeverMade)
{
    RequestHead head = page_request();
    head.target = "/?token=";
    EXPECT_EQ(admit(head, {"", 4711}), Admission::BadToken);
}

TEST(RequestCheck, RefusesAddressesThatAreNone)
{
    RequestHead head = page_request();
    const std::string token = "?token=0123456789abcdef0123456789abcdef";
    const std::string targets[] = {"",
                                   "x",
                                   "http://127.0.0.1:4711/" + token,
                                   "/../etc/passwd" + token,
                                   "/a/..%2f" + token,
                                   "/<script>" + token,
                                   "/a b" + token,
                                   std::string("/a\0b", 4) + token,
                                   "/" + std::string(k_max_target, 'a') + token,
                                   "/\xc3\xa4" + token,
                                   "/a\\b" + token};
    for (const std::string& target : targets) {
        head.target = target;
        EXPECT_EQ(admit(head, k_guard), Admission::BadTarget) << target;
    }
}

TEST(RequestCheck, TokensAreLongAndNeverTheSame)
{
    const std::string a = random_token(), b = random_token();
    EXPECT_EQ(a.size(), 32u);
    EXPECT_EQ(a.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_NE(a, b);
}

}  // namespace
}  // namespace sqmap::viewer
