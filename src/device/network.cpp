#include "device/network.h"

#include "device/families.h"
#include "device/threaded.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace sqmap::device {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are little-endian and copied as they are");

constexpr std::uint32_t k_magic = 0x4e4d5153;  // "SQMN"
constexpr double k_unknown_rate = 1000;        // Hz
constexpr double k_silence = 1.0;              // s after which a client is gone
constexpr std::size_t k_name = 32;
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

enum Kind : std::uint16_t { k_hello = 1, k_welcome = 2, k_refused = 3, k_pose = 4, k_wrench = 5, k_bye = 6, k_resume = 7 };
enum Reason : std::uint32_t { k_busy = 1, k_version = 2, k_bad_hello = 3, k_other_device = 4 };
enum HelloFlag : std::uint32_t { k_rotates = 1, k_force = 2, k_torque = 4, k_rumble = 8 };
enum PoseFlag : std::uint32_t { k_has_twist = 1 };

/// Takes values off the front of a message; ok turns false if it is too short.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    template <class T>
    T take()
    {
        T value{};
        ok = ok && bytes_.size() >= sizeof(T);
        if (!ok) return value;
        std::memcpy(&value, bytes_.data(), sizeof(T));
        bytes_ = bytes_.subspan(sizeof(T));
        return value;
    }
    double number()
    {
        const double value = take<double>();
        finite = finite && std::isfinite(value);
        return value;
    }
    Vec3d vector()
    {
        const double x = number(), y = number(), z = number();
        return {x, y, z};
    }
    [[nodiscard]] bool done() const { return ok && bytes_.empty(); }
    bool ok = true;      ///< nothing was missing
    bool finite = true;  ///< every number() was

private:
    std::span<const std::byte> bytes_;
};

class Writer {
public:
    template <class T>
    void put(T value)
    {
        std::memcpy(bytes_.data() + size_, &value, sizeof value);
        size_ += sizeof value;
    }
    void header(Kind kind, std::uint64_t sequence)
    {
        put(k_magic);
        put(static_cast<std::uint16_t>(k_network_version));
        put(static_cast<std::uint16_t>(kind));
        put(sequence);
    }
    void vector(Vec3d v)
    {
        put(v.x);
        put(v.y);
        put(v.z);
    }
    [[nodiscard]] std::span<const std::byte> bytes() const { return std::span(bytes_).first(size_); }

private:
    std::array<std::byte, 32 + 48 * k_max_zones> bytes_{};
    std::size_t size_ = 0;
};

bool same_address(const sockaddr_in& a, const sockaddr_in& b)
{
    return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

std::optional<Capabilities> capabilities_of(Reader in)
{
    Capabilities c;
    c.zones = in.take<std::uint32_t>();
    const auto flags = in.take<std::uint32_t>();
    c.rate = in.number();
    if (c.rate == 0) c.rate = k_unknown_rate;
    c.max_force = in.number();
    c.max_torque = in.number();
    c.continuous_force = in.number();
    c.damping = in.number();
    c.coulomb_friction = in.number();
    c.resolution = in.number();
    c.delay = in.number();
    const auto name = in.take<std::array<char, k_name>>();
    const double numbers[] = {c.max_force,  c.max_torque, c.continuous_force, c.damping, c.coulomb_friction,
                              c.resolution, c.delay};
    if (!in.done() || !in.finite || c.zones < 1 || c.zones > k_max_zones || !(c.rate >= 1 && c.rate <= 1e5) ||
        std::any_of(std::begin(numbers), std::end(numbers), [](double x) { return x < 0; }))
        return std::nullopt;
    c.rotates_in = (flags & k_rotates) != 0;
    c.force_out = (flags & k_force) != 0;
    c.torque_out = (flags & k_torque) != 0;
    c.rumble_out = (flags & k_rumble) != 0;
    std::string printable;
    for (const char letter : name) {
        if (letter == 0) break;
        printable += letter >= ' ' && letter < 127 ? letter : '?';
    }
    c.name = "network client '" + printable + "'";
    // The wrench computed for a pose goes out with the answer to the next one.
    c.delay += 1 / c.rate;
    return c;
}

/// True where two devices can do the same; their names may differ.
bool same(Capabilities a, const Capabilities& b)
{
    a.name = b.name;
    return a == b;
}

/// A bound socket, or a reason in errno.
int listen_on(const NetworkOptions& options)
{
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(options.port);
    if (::inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1)
        errno = EINVAL;
    else if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
        return fd;
    const int error = errno;
    ::close(fd);
    errno = error;
    return -1;
}

class NetworkDevice final : public ThreadedDevice {
public:
    explicit NetworkDevice(const NetworkOptions& options) : fd_(listen_on(options))
    {
        const std::string address = options.address + ":" + std::to_string(options.port);
        if (fd_ < 0) throw DeviceError("network: cannot listen on " + address + ": " + std::strerror(errno));
        start([this] { run(); });
        if (wait_for_sample(options.wait)) return;
        stop();
        ::close(fd_);
        char seconds[32];
        std::snprintf(seconds, sizeof seconds, "%g", options.wait);
        throw DeviceError("network: no client said hello and sent a pose to " + address + " within " + seconds +
                          " s\n  cure: start it, or wait longer with network:wait=60; see docs/devices.md");
    }
    ~NetworkDevice() override
    {
        stop();
        if (client_) {
            // Sends zero force three times, because a datagram may be lost.
            channel_.zero();
            for (int i = 0; i < 3; ++i) send_wrenches(channel_.output(now()), 0);
            Writer out;
            out.header(k_bye, ++sent_);
            send(*client_, out);
        }
        ::close(fd_);
    }

private:
    void run()
    {
        // One byte more than the longest message: a full buffer means that the message is too long.
        std::array<std::byte, 40 + 104 * k_max_zones + 1> buffer;
        while (!stopping()) {
            pollfd wait{fd_, POLLIN, 0};
            ::poll(&wait, 1, 2);
            for (int i = 0; i < 64; ++i) {  // then look at stopping() again
                sockaddr_in from{};
                socklen_t length = sizeof from;
                const ssize_t n = ::recvfrom(fd_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
                if (n < 0) break;
                receive(std::span(buffer).first(static_cast<std::size_t>(n)), from);
            }
            if (client_ && now() - heard_ > k_silence) forget();
        }
    }

    void receive(std::span<const std::byte> bytes, const sockaddr_in& from)
    {
        Reader in(bytes);
        const auto magic = in.take<std::uint32_t>();
        const auto version = in.take<std::uint16_t>();
        const auto kind = in.take<std::uint16_t>();
        const auto sequence = in.take<std::uint64_t>();
        if (!in.ok || magic != k_magic) return;  // no answer: it may be anything
        if (kind == k_hello) return hello(version, in, from);
        if (version != k_network_version || !client_ || !same_address(*client_, from) || in.take<std::uint64_t>() != token_ ||
            !in.ok)
            return;
        if (kind == k_bye) return forget();
        if (kind == k_resume && in.done()) ++resumes_;  // the filter learns of it with the next pose
        if (kind == k_pose) pose(sequence, in);
    }

    void hello(std::uint16_t version, const Reader& in, const sockaddr_in& from)
    {
        if (version != k_network_version) return refuse(from, k_version);
        const std::optional<Capabilities> said = capabilities_of(in);
        if (!said) return refuse(from, k_bad_hello);
        if (client_ && !same_address(*client_, from)) return refuse(from, k_busy);
        if (known_ && !same(*said, capabilities_)) return refuse(from, k_other_device);
        if (!known_) capabilities_ = *said;  // before the first publish, for which the opener waits
        known_ = true;
        client_ = from;
        heard_ = now();
        newest_ = 0;
        if (::getrandom(&token_, sizeof token_, 0) != static_cast<ssize_t>(sizeof token_)) return forget();
        Writer out;
        out.header(k_welcome, ++sent_);
        out.put(token_);
        send(from, out);
    }

    void pose(std::uint64_t sequence, Reader in)
    {
        if (sequence <= newest_) return;  // late or twice
        Sample sample;
        sample.time = now();
        sample.resumes = resumes_;
        (void)in.take<double>();  // the client's clock, for its own records
        sample.buttons = in.take<std::uint32_t>();
        sample.has_twist = (in.take<std::uint32_t>() & k_has_twist) != 0;
        bool rotations = true;
        for (std::size_t z = 0; z < capabilities_.zones; ++z) {
            sample.poses[z].translation = in.vector();
            const double w = in.take<double>(), x = in.take<double>(), y = in.take<double>(), q = in.take<double>();
            rotations = unit_rotation(w, x, y, q, sample.poses[z].rotation) && rotations;
            if (!sample.has_twist) continue;
            sample.twists[z].linear = in.vector();
            sample.twists[z].angular = in.vector();
        }
        if (!in.done()) return;
        newest_ = sequence;
        heard_ = sample.time;
        if (!rotations || !in.finite) {
            // An impossible pose must not pass for silence, which would hold the last force for a while: the filter gets NaN, and
            // the client gets zero force at once.
            sample.poses[0].translation = {k_nan, k_nan, k_nan};
            channel_.publish(sample);
            channel_.spoil();
            channel_.zero();
            return send_wrenches(channel_.output(sample.time), sequence);
        }
        channel_.publish(sample);
        send_wrenches(channel_.output(sample.time), sequence);
    }

    void send_wrenches(const std::array<Wrench, k_max_zones>& wrenches, std::uint64_t answered)
    {
        Writer out;
        out.header(k_wrench, ++sent_);
        out.put(answered);
        out.put(static_cast<std::uint32_t>(capabilities_.zones));
        out.put(channel_.filter());
        for (std::size_t z = 0; z < capabilities_.zones; ++z) {
            out.vector(wrenches[z].force);
            out.vector(wrenches[z].torque);
        }
        send(*client_, out);
    }

    void refuse(const sockaddr_in& from, Reason reason)
    {
        Writer out;
        out.header(k_refused, ++sent_);
        out.put(static_cast<std::uint32_t>(reason));
        out.put(k_network_version);
        send(from, out);
    }

    void forget()
    {
        client_.reset();
        channel_.lose();
    }

    void send(const sockaddr_in& to, const Writer& out) noexcept
    {
        // A datagram that does not fit the socket's buffer is lost, as any may be.
        (void)!::sendto(fd_, out.bytes().data(), out.bytes().size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }

    int fd_;
    // The thread's own from here on; the destructor's once it has joined.
    std::optional<sockaddr_in> client_{};
    bool known_ = false;  ///< capabilities_ are the client's
    std::uint64_t token_ = 0, newest_ = 0, sent_ = 0;
    std::uint32_t resumes_ = 0;
    double heard_ = 0;
};

}  // namespace

std::unique_ptr<Device> open_network(const NetworkOptions& options) { return std::make_unique<NetworkDevice>(options); }

std::unique_ptr<Device> open_network(const DeviceSpec& spec)
{
    spec.allow({"port", "wait"});
    NetworkOptions options;
    if (!spec.first.empty()) options.address = spec.first;
    options.port = static_cast<std::uint16_t>(spec.whole("port", k_network_port, 1, 65535));
    options.wait = spec.number("wait", options.wait, 0.1, 86400);
    return open_network(options);
}

void list_network(std::vector<DeviceListing>& list)
{
    list.push_back({"network", Presence::Here, "waits for another program on UDP 127.0.0.1:" + std::to_string(k_network_port),
                    Capabilities{.name = "network", .rotates_in = true, .force_out = true, .torque_out = true}});
}

}  // namespace sqmap::device
