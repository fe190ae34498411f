#include "sqmap/device/open.h"

#include "sqmap/device/path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace sqmap::device {
namespace {

TEST(Spec, HasKindFirstArgumentAndOptions)
{
    const DeviceSpec spec = parse_spec("network:10.0.0.1,port=5,wait=2.5,name=a=b");
    EXPECT_EQ(spec.kind, "network");
    EXPECT_EQ(spec.first, "10.0.0.1");
    EXPECT_EQ(spec.text("port", "x"), "5");
    EXPECT_EQ(spec.text("name", ""), "a=b");
    EXPECT_EQ(spec.text("absent", "otherwise"), "otherwise");
    EXPECT_EQ(spec.number("wait", 0, 0, 10), 2.5);
    EXPECT_EQ(spec.number("absent", 7, 0, 1), 7);
    EXPECT_EQ(parse_spec("sdl").kind, "sdl");
    EXPECT_EQ(parse_spec("sdl:").first, "");
    EXPECT_EQ(parse_spec("sdl:range=1").text("range", ""), "1");
}

TEST(Spec, RefusesWhatItCannotMean)
{
    for (const char* const text : {"", ":x", "a:b,c", "a:b,=1", "a:x=1,x=2", "a:b=1,", "a:,b=1", "a:b=1,,c=2"})
        EXPECT_THROW((void)parse_spec(text), DeviceError) << text;
    const DeviceSpec spec = parse_spec("k:a=1,b=x,c=nan,d=1e9,e=,f=1.5");
    for (const char* const name : {"b", "c", "d", "e"}) EXPECT_THROW((void)spec.number(name, 0, 0, 10), DeviceError) << name;
    EXPECT_EQ(spec.whole("a", 0, 0, 10), 1);
    EXPECT_EQ(spec.whole("absent", 7, 0, 1), 7);
    EXPECT_THROW((void)spec.whole("f", 0, 0, 10), DeviceError);
    EXPECT_THROW(spec.allow({"a"}), DeviceError);
    EXPECT_NO_THROW(spec.allow({"a", "b", "c", "d", "e", "f"}));
    EXPECT_NO_THROW(spec.only_named());
    EXPECT_THROW(parse_spec("k:first,a=1").only_named(), DeviceError);
    EXPECT_EQ(parse_spec("k").index(3, 0, 9), 3);
    EXPECT_EQ(parse_spec("k:2").index(3, 0, 9), 2);
    EXPECT_THROW((void)parse_spec("k:2.5").index(3, 0, 9), DeviceError);
}

TEST(OpenDevice, RefusesKindsAndOptionsThatDoNotExist)
{
    for (const char* const spec :
         {"", "teleporter", "path", "path:/no/such/file", "trace", "trace:/no/such/file", "network:wait=0", "network:port=70000",
          "network:hat=1", "network:300.1.2.3,wait=0.1", "sdl:-1", "sdl:x", "sdl:0.5", "haply:port=0", "haply:port=80.5",
          "haply:max-force=0", "network:port=", "network:wait=1,", "spacenav:first"})
        EXPECT_THROW((void)open_device(spec), DeviceError) << spec;
}

TEST(ListDevices, SaysOfEveryKindWhetherItIsHere)
{
    const std::vector<DeviceListing> list = list_devices();
    std::set<std::string> kinds;
    for (const DeviceListing& entry : list) {
        EXPECT_FALSE(entry.state.empty()) << entry.spec;
        kinds.insert(entry.spec.substr(0, entry.spec.find(':')));
        // A device that is not built cannot be opened, and the reason is the same in both messages.
        if (entry.presence != Presence::NotBuilt) continue;
        try {
            (void)open_device(entry.spec);
            ADD_FAILURE() << entry.spec << " opened";
        } catch (const DeviceError& e) {
            EXPECT_NE(std::string(e.what()).find(entry.state), std::string::npos) << e.what();
        }
    }
    EXPECT_EQ(kinds, (std::set<std::string>{"path", "trace", "network", "sdl", "spacenav", "haply", "openhaptics",
                                            "forcedimension", "chai3d"}));
    for (const DeviceListing& entry : list)
        EXPECT_EQ(entry.capabilities.simulated, entry.spec == "path:FILE" || entry.spec == "trace:FILE");
}

}  // namespace
}  // namespace sqmap::device
