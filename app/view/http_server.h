// cpp-httplib's server with limits of ours: so many requests at a time, each before a deadline.
#pragma once

#include <httplib.h>

#include <atomic>
#include <cstddef>

#include "app/view/connection.h"
#include "app/view/server.h"

namespace gpvc::view {

class HttpServer final : public httplib::Server {
 public:
  explicit HttpServer(const ServerOptions& options);
  /// The library lets five connections wait for the system to hand them over; a sixth then tries again after a second. To be called once
  /// a port is bound.
  void let_more_wait();
  std::atomic<bool> stopped = false;

 private:
  bool process_and_close_socket(int socket) override;
  const ServerOptions options_;
  std::atomic<std::size_t> waiting_ = 0;
};

/// Whose request this thread answers; null: none of an HttpServer's.
Connection* connection_now();

}  // namespace gpvc::view
