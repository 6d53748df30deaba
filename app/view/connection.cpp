#include "app/view/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace gpvc::view {
namespace {

using std::chrono::milliseconds;

// False after the time, or where the connection is broken.
bool ready(int socket, short event, milliseconds longest) {
  pollfd asked{socket, event, 0};
  int found = 0;
  do found = poll(&asked, 1, static_cast<int>(longest.count()));
  while (found < 0 && errno == EINTR);
  return found > 0 && (asked.revents & (event | POLLHUP)) != 0;
}

}  // namespace

bool Connection::wait_for_request(milliseconds longest, const std::atomic<bool>& stopped) const {
  constexpr milliseconds kStep{50};
  for (milliseconds waited{0}; waited < longest && !stopped; waited += kStep)
    if (ready(socket_, POLLIN, kStep)) return true;
  return false;
}

bool Connection::wait(short event) const {
  if (deadline_ == Clock::time_point::max()) return ready(socket_, event, milliseconds(10'000));
  const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - Clock::now());
  return left.count() > 0 && ready(socket_, event, std::min(left, milliseconds(600'000)));
}

bool Connection::is_readable() const { return wait(POLLIN); }
bool Connection::is_writable() const { return wait(POLLOUT); }

ssize_t Connection::read(char* to, std::size_t size) {
  if (!wait(POLLIN)) return -1;
  ssize_t got = 0;
  do got = recv(socket_, to, size, 0);
  while (got < 0 && errno == EINTR);
  return got;
}

ssize_t Connection::write(const char* from, std::size_t size) {
  if (!wait(POLLOUT)) return -1;
  ssize_t sent = 0;
  do sent = send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
  while (sent < 0 && errno == EINTR);
  return sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK) ? 0 : sent;
}

void Connection::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip = "127.0.0.1";
  port = 0;
}
void Connection::get_local_ip_and_port(std::string& ip, int& port) const { get_remote_ip_and_port(ip, port); }

}  // namespace gpvc::view
