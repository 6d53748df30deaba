// One connection of the server: bytes in and out, all before a deadline, so that a slow client holds a thread no longer.
#pragma once

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <string>

namespace gpvc::view {

class Connection final : public httplib::Stream {
 public:
  using Clock = std::chrono::steady_clock;
  /// Does not own the socket.
  explicit Connection(int socket) : socket_(socket) {}

  /// read() and write() fail from then on; Clock::time_point::max(): never.
  void set_deadline(Clock::time_point deadline) { deadline_ = deadline; }
  /// No further request is read: what is left of this one would be taken for it.
  void end_after_answer() { ends_ = true; }
  bool ends() const { return ends_; }
  /// True once there is something to read; false after the time, or when `stopped`.
  bool wait_for_request(std::chrono::milliseconds longest, const std::atomic<bool>& stopped) const;

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  int socket() const override { return socket_; }

 private:
  bool wait(short event) const;
  int socket_;
  bool ends_ = false;
  Clock::time_point deadline_ = Clock::time_point::max();
};

}  // namespace gpvc::view
