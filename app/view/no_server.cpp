// In the place of server.cpp where the library for HTTP was not there when the program was built.
#include "app/view/server.h"
#include "io/error.h"

namespace gpvc::view {

Server::Server(Answer, const ServerOptions&) {
  throw Error(
      "the server is not part of this program: cpp-httplib 0.11 or 0.12 was missing when it was built (Debian 12: "
      "libcpp-httplib-dev)");
}
Server::~Server() = default;
int Server::port() const { return 0; }
const std::string& Server::token() const {
  static const std::string none;
  return none;
}
std::string Server::address() const { return ""; }
void Server::run(const std::function<bool()>&) {}
void Server::tell(const std::string&, const std::string&) {}
std::size_t Server::pages() const { return 0; }

}  // namespace gpvc::view
