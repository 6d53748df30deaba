// Who may ask the server: the page that this program opened, and no other page, user or name.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gpvc::view {

/// 128 random bits of the system in 32 hexadecimal digits. Throws Error where there are none.
std::string random_token();

/// Takes as long for any two texts of the same length, so that time tells nothing of a token.
bool same_secret(std::string_view given, std::string_view expected);

/// What a browser says of where a request comes from; empty: it does not say.
struct RequestOrigin {
  std::string_view host, origin, fetch_site;
};

/// The sentence to refuse a request with; nullopt: it may pass. A Host that is not this server's own address is a foreign name that
/// resolves to this machine; another Origin is a page of somebody else.
std::optional<std::string> refusal(const RequestOrigin& from, int port);

/// The part of a path behind "/TOKEN/"; nullopt where the token is not there, or where the path has a part "..", a backslash or a
/// control character. \param path decoded
std::optional<std::string> below_token(std::string_view path, std::string_view token);

}  // namespace gpvc::view
