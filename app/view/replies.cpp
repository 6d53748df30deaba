// What a server answers with, as values; apart from server.cpp, which is left out where there is no library for HTTP.
#include <utility>

#include "app/results/observer.h"
#include "app/view/server.h"

namespace gpvc::view {

Reply bytes_reply(std::string type, std::string bytes) {
  return {200, std::move(type), std::make_shared<const std::string>(std::move(bytes)), {}, {}};
}

Reply text_reply(int status, const std::string& text) {
  Reply reply = bytes_reply("text/plain; charset=utf-8", results::printable(text));
  reply.status = status;
  return reply;
}

}  // namespace gpvc::view
