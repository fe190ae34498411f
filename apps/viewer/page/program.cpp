// The viewer's program in a worker of a browser: what its server sends goes to the page as messages of the worker, and back.
// worker.js is the other side.
#include "viewer/server/viewer.h"

#include <emscripten.h>

#include <memory>
#include <string>

// clang-format off
EM_JS(void, page_hears_text, (const char* text, int size), { Module.onText(UTF8ToString(text, size)); });
EM_JS(void, page_hears_bytes, (const char* bytes, int size), { Module.onBytes(HEAPU8.slice(bytes, bytes + size)); });
EM_JS(void, page_gets_answer, (int id, int status, const char* type, const char* body, int size), {
  Module.onAnswer(id, status, UTF8ToString(type), HEAPU8.slice(body, body + size));
});
// clang-format on

namespace sqmap::viewer {

/// There is one page, and nothing waits: it takes what it is sent at once.
struct Server::State {};

Server::Server(Application& /*application*/, const ServerOptions& /*options*/) : state_(std::make_shared<State>()) {}
Server::~Server() = default;
void Server::post(std::function<void()> work) { work(); }

void Server::send_text(ConnectionId /*connection*/, std::string text)
{
    page_hears_text(text.data(), static_cast<int>(text.size()));
}

void Server::send_binary(ConnectionId /*connection*/, std::shared_ptr<const std::string> bytes, bool /*droppable*/)
{
    page_hears_bytes(bytes->data(), static_cast<int>(bytes->size()));
}

namespace {

constexpr ConnectionId k_page = 1;

struct Program {
    Program() { viewer.attach(server); }

    Viewer viewer{{}, {}};
    Server server{viewer, {}};
};

/// For as long as the worker lives.
Program& program()
{
    static auto& all = *new Program;
    return all;
}

}  // namespace
}  // namespace sqmap::viewer

using namespace sqmap::viewer;

extern "C" {

/// Connects the page; the viewer sends it the scene.
EMSCRIPTEN_KEEPALIVE void page_open() { program().viewer.on_open(k_page); }

/// A message of the page.
EMSCRIPTEN_KEEPALIVE void page_says(const char* text) { program().viewer.on_text(k_page, text); }

/// Answers a request of the page: a fetch, or a post where there is a body.
EMSCRIPTEN_KEEPALIVE void page_fetches(int id, const char* target, const char* body, int size)
{
    HttpRequest request{.method = body != nullptr ? "POST" : "GET", .target = target, .body = {}};
    if (body != nullptr) request.body.assign(body, static_cast<std::size_t>(size));
    program().viewer.on_http(std::move(request), [id](const HttpReply& reply) {
        page_gets_answer(id, reply.status, reply.type.c_str(), reply.body.data(), static_cast<int>(reply.body.size()));
    });
}

/// Some 60 times a second: the ticks that are due, and what they felt.
EMSCRIPTEN_KEEPALIVE void page_frame() { program().viewer.on_frame(); }

/// One job; 0 where none waits.
EMSCRIPTEN_KEEPALIVE int page_work() { return program().viewer.do_next() ? 1 : 0; }
}
