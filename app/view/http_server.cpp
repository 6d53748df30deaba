#include "app/view/http_server.h"

#include <sys/socket.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace gpvc::view {
namespace {

thread_local Connection* answered_now = nullptr;  // whose request this thread answers
thread_local bool refuses_now = false;            // the connection that comes is one too many

// So many threads and so many connections that wait for one.
class BoundedQueue final : public httplib::TaskQueue {
 public:
  BoundedQueue(std::size_t threads, std::size_t most_waiting, std::atomic<std::size_t>& waiting)
      : most_waiting_(most_waiting), waiting_(waiting) {
    for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  }
  void enqueue(std::function<void()> task) override {
    {
      const std::lock_guard lock(mutex_);
      if (tasks_.size() < most_waiting_) {
        tasks_.push_back(std::move(task));
        waiting_ = tasks_.size();
        changed_.notify_one();
        return;
      }
    }
    refuses_now = true;
    task();
    refuses_now = false;
  }
  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  void work() {
    for (;;) {
      std::function<void()> task;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return ends_ || !tasks_.empty(); });
        if (tasks_.empty()) return;
        task = std::move(tasks_.front());
        tasks_.pop_front();
        waiting_ = tasks_.size();
      }
      task();
    }
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  bool ends_ = false;
  std::size_t most_waiting_;
  std::atomic<std::size_t>& waiting_;
  std::vector<std::thread> threads_;
};

}  // namespace

Connection* connection_now() { return answered_now; }

HttpServer::HttpServer(const ServerOptions& options) : options_(options) {
  new_task_queue = [this] { return new BoundedQueue(options_.threads, options_.most_waiting, waiting_); };
}

void HttpServer::let_more_wait() {
  constexpr int kBacklog = 128;
  static_cast<void>(::listen(svr_sock_, kBacklog));
}

bool HttpServer::process_and_close_socket(int socket) {
  if (!refuses_now) {
    Connection connection(socket);
    answered_now = &connection;
    constexpr int kMostRequests = 1000;
    bool closed = false;
    for (int n = 0; n < kMostRequests && !closed && !stopped && !connection.ends(); ++n) {
      // Idle connections make room for those that wait.
      const auto idle = n > 0 && waiting_ > 0 ? std::chrono::milliseconds(50) : options_.idle;
      if (!connection.wait_for_request(idle, stopped)) break;
      connection.set_deadline(Connection::Clock::now() + options_.to_ask);
      if (!process_request(connection, n + 1 == kMostRequests, closed, [](httplib::Request&) {})) break;
    }
    answered_now = nullptr;
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return true;
}

}  // namespace gpvc::view
