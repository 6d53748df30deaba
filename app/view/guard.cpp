#include "app/view/guard.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "io/error.h"

namespace gpvc::view {

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  ssize_t got = -1;
  do got = getrandom(bytes.data(), bytes.size(), 0);
  while (got < 0 && errno == EINTR);
  if (got != static_cast<ssize_t>(bytes.size())) throw Error("the system has no random numbers for the page's address");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_secret(std::string_view given, std::string_view expected) {
  if (given.size() != expected.size()) return false;
  unsigned char differs = 0;
  for (std::size_t i = 0; i < given.size(); ++i)
    differs = static_cast<unsigned char>(differs | (given[i] ^ expected[i]));
  return differs == 0;
}

std::optional<std::string> refusal(const RequestOrigin& from, int port) {
  const std::string numeric = fmt::format("127.0.0.1:{}", port), named = fmt::format("localhost:{}", port);
  if (from.host != numeric && from.host != named) return "the address of this page begins with another name";
  if (!from.origin.empty() && from.origin != "http://" + std::string(from.host))
    return "pages of other origins may not ask here";
  if (from.fetch_site == "cross-site" || from.fetch_site == "same-site") return "pages of other sites may not ask here";
  return std::nullopt;
}

std::optional<std::string> below_token(std::string_view path, std::string_view token) {
  if (!path.starts_with('/')) return std::nullopt;
  path.remove_prefix(1);
  const std::size_t end = path.find('/');
  if (end == std::string_view::npos || !same_secret(path.substr(0, end), token)) return std::nullopt;
  path.remove_prefix(end + 1);
  for (const char c : path)
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == 0x7F) return std::nullopt;
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t slash = std::min(path.find('/', at), path.size());
    if (path.substr(at, slash - at) == "..") return std::nullopt;
    at = slash + 1;
  }
  return std::string(path);
}

}  // namespace gpvc::view
