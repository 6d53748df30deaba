#include "app/view/server.h"

#include <fmt/format.h>
#include <sys/socket.h>

#include <exception>
#include <thread>

#include "app/view/events.h"
#include "app/view/guard.h"
#include "app/view/http_server.h"
#include "io/error.h"
#include "io/file_bytes.h"

namespace gpvc::view {
namespace {

using Clock = Connection::Clock;

constexpr std::size_t kMostPages = 8;  // each holds a thread
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: "
    "data:; "
    "connect-src 'self' blob:; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

void set(httplib::Response& to, const Reply& reply) {
  to.status = reply.status;
  if (reply.fresh.count() > 0)
    to.set_header("Cache-Control", fmt::format("private, max-age={}", reply.fresh.count()));
  else
    to.set_header("Cache-Control", "no-store");
  std::string_view bytes;
  std::shared_ptr<const void> keeper = reply.body;
  if (reply.body) {
    bytes = *reply.body;
  } else {
    const auto file = std::make_shared<const io::FileBytes>(reply.file);
    bytes = file->view();
    keeper = file;
  }
  if (bytes.empty()) {
    to.set_content("", reply.type);
    return;
  }
  to.set_content_provider(bytes.size(), reply.type,
                          [bytes, keeper](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                            constexpr std::size_t kPiece = std::size_t{1} << 18;
                            return sink.write(bytes.data() + offset, std::min(length, kPiece));
                          });
}

}  // namespace

struct Server::State {
  State(Answer given, const ServerOptions& with) : answer(std::move(given)), options(with), http(with) {}
  Answer answer;
  ServerOptions options;
  HttpServer http;
  Events events;
  std::string token = random_token();
  int port = 0;

  void route(const httplib::Request& asked, httplib::Response& to, bool posts) {
    if (connection_now()) connection_now()->set_deadline(Clock::now() + options.to_answer);
    const auto path = below_token(asked.path, token);
    if (!path) return set(to, text_reply(404, "not found"));
    if (*path == "events" && !posts) return listen(to);
    set(to, answered(asked, *path, posts));
  }
  Reply answered(const httplib::Request& asked, const std::string& path, bool posts) {
    try {
      Request request{posts, path, {}, asked.body};
      for (const auto& [name, value] : asked.params) request.query.emplace(name, value);
      return answer(request);
    } catch (const InputError& e) {
      return text_reply(400, e.what());
    } catch (const std::exception& e) {
      return text_reply(500, e.what());
    }
  }
  void listen(httplib::Response& to) {
    if (++events.listeners > kMostPages) {
      --events.listeners;
      return set(to, text_reply(503, "too many pages are open"));
    }
    ++events.ever;
    if (connection_now()) connection_now()->set_deadline(Clock::time_point::max());
    to.set_header("Cache-Control", "no-store");
    to.set_chunked_content_provider(
        "text/event-stream",
        [this, next = events.end()](std::size_t, httplib::DataSink& sink) mutable {
          if (events.closed) return false;
          const std::string text = events.since(next);
          return sink.write(text.data(), text.size());
        },
        [this](bool) { --events.listeners; });
  }
  // Before a request's body is read.
  bool passes(const httplib::Request& asked, httplib::Response& to) const {
    const std::string host = asked.get_header_value("Host"), origin = asked.get_header_value("Origin"),
                      site = asked.get_header_value("Sec-Fetch-Site");
    std::optional<Reply> no;
    if (const auto sentence = refusal({host, origin, site}, port))
      no = text_reply(403, *sentence);
    else if (!below_token(asked.path, token))
      no = text_reply(404, "not found");
    else if (asked.method != "GET" && asked.method != "POST")
      no = text_reply(405, "expected GET or POST");
    else if (asked.has_header("Transfer-Encoding"))
      no = text_reply(411, "expected a request of stated length");
    else if (asked.method == "POST" && asked.get_header_value("Content-Type") != "application/json")
      no = text_reply(415, "expected application/json");
    else if (asked.has_header("Content-Encoding"))
      no = text_reply(415, "expected a request that is not compressed");
    else if (asked.has_header("Range"))
      no = text_reply(416, "expected a request for the whole");
    if (!no) return true;
    if (connection_now()) connection_now()->end_after_answer();
    set(to, *no);
    return false;
  }
};

Server::Server(Answer answer, const ServerOptions& options)
    : state_(std::make_shared<State>(std::move(answer), options)) {
  State& state = *state_;
  httplib::Server& http = state.http;
  http.set_payload_max_length(options.most_body_bytes);
  http.set_tcp_nodelay(true);
  // Not SO_REUSEPORT, which is the library's choice: another program could listen on the same port.
  http.set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  http.set_default_headers({{"Content-Security-Policy", kPolicy},
                            {"X-Content-Type-Options", "nosniff"},
                            {"Referrer-Policy", "no-referrer"},
                            {"Cross-Origin-Resource-Policy", "same-origin"},
                            {"Cross-Origin-Opener-Policy", "same-origin"},
                            {"X-Frame-Options", "DENY"}});
  http.set_pre_routing_handler([&state](const httplib::Request& asked, httplib::Response& to) {
    using Handled = httplib::Server::HandlerResponse;
    return state.passes(asked, to) ? Handled::Unhandled : Handled::Handled;
  });
  http.Get(".*", [&state](const httplib::Request& asked, httplib::Response& to) { state.route(asked, to, false); });
  http.Post(".*", [&state](const httplib::Request& asked, httplib::Response& to) { state.route(asked, to, true); });
  state.port = options.port == 0                              ? http.bind_to_any_port("127.0.0.1")
               : http.bind_to_port("127.0.0.1", options.port) ? options.port
                                                              : -1;
  if (state.port <= 0)
    throw Error(options.port == 0 ? "no port of 127.0.0.1 is free"
                                  : fmt::format("port {} of 127.0.0.1 is not free", options.port));
  state.http.let_more_wait();
}

Server::~Server() = default;

int Server::port() const { return state_->port; }
const std::string& Server::token() const { return state_->token; }
std::string Server::address() const { return fmt::format("http://127.0.0.1:{}/{}/", state_->port, state_->token); }
void Server::tell(const std::string& event, const std::string& data) { state_->events.tell(event, data); }
std::size_t Server::pages() const { return state_->events.listeners; }

void Server::run(const std::function<bool()>& ends) {
  State& state = *state_;
  std::thread listening([&state] { state.http.listen_after_bind(); });
  Clock::time_point last_page = Clock::now();
  while (!ends()) {
    if (state.events.listeners > 0 || state.events.ever == 0) last_page = Clock::now();
    if (Clock::now() - last_page > state.options.without_page) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  state.events.close();
  state.http.stopped = true;
  while (!state.http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  state.http.stop();
  listening.join();
}

}  // namespace gpvc::view
