// Serves one page, and what it asks for, to the browser of this machine.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace gpvc::view {

/// What the page asks for: a path below the address, decoded.
struct Request {
  bool posts = false;
  std::string path;
  std::map<std::string, std::string> query{};
  std::string body{};
};

/// The bytes to answer with: `body`, or if that is null those of a file.
struct Reply {
  int status = 200;
  std::string type{};  ///< "image/jpeg"
  std::shared_ptr<const std::string> body{};
  std::filesystem::path file{};
  std::chrono::seconds fresh{0};  ///< how long the browser may keep it without asking again
};
Reply text_reply(int status, const std::string& text);
Reply bytes_reply(std::string type, std::string bytes);

struct ServerOptions {
  int port = 0;                                        ///< 0: one that is free
  std::size_t most_body_bytes = std::size_t{4} << 20;  ///< larger requests are refused
  std::size_t threads = 16;                            ///< requests that are answered at the same time
  std::size_t most_waiting = 64;                       ///< further connections are closed at once
  std::chrono::milliseconds to_ask{10'000};            ///< from the first byte of a request to its last
  std::chrono::milliseconds to_answer{120'000};        ///< until the last byte of an answer is taken
  std::chrono::milliseconds idle{3'000};               ///< between two requests of a connection
  std::chrono::milliseconds without_page{6'000};       ///< run() ends so long after the last page was closed
};

/// Listens on 127.0.0.1 alone, under an address with a random token, and answers nobody else (guard.h). `answer` is called on several
/// threads; what it throws becomes a sentence with status 400 (InputError) or 500.
class Server {
 public:
  using Answer = std::function<Reply(const Request&)>;
  /// Listens from now on. Throws Error where the port is not free.
  Server(Answer answer, const ServerOptions& options = {});
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const;
  const std::string& token() const;
  /// "http://127.0.0.1:PORT/TOKEN/"
  std::string address() const;

  /// Answers until `ends` is true or all pages that listened for events have been closed.
  void run(const std::function<bool()>& ends);
  /// Sends an event to all pages that listen at "events". \param data one line
  void tell(const std::string& event, const std::string& data);
  /// Pages that listen now.
  std::size_t pages() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< of this value alone
};

}  // namespace gpvc::view
