#include "app/view/job.h"

#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/evaluate/json.h"

namespace gpvc::view {
namespace {

using evaluate::Json;

std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

class Reporter final : public results::Observer {
 public:
  Reporter(const Tell& tell, const std::atomic<bool>& cancelled) : tell_(tell), cancelled_(cancelled) {}
  void begin(const results::StageInfo& stage) override {
    check_cancelled();
    stage_ = stage;
    tell_(line_of({{"stage", stage.name}}));
  }
  void progress(std::size_t done, std::size_t total) override {
    check_cancelled();
    tell_(line_of({{"stage", stage_.name}, {"done", done}, {"total", total}, {"unit", stage_.unit}}));
  }
  void end(const std::string&) override { check_cancelled(); }
  void warning(const std::string& text, const std::vector<Cure>&) override {
    tell_(line_of({{"warning", results::printable(text)}}));
  }
  void check_cancelled() override {
    if (cancelled_) throw Cancelled();
  }

 private:
  const Tell& tell_;
  const std::atomic<bool>& cancelled_;
  results::StageInfo stage_;
};

}  // namespace

Job::~Job() {
  cancelled_ = true;
  if (thread_.joinable()) thread_.join();
}

bool Job::start(std::function<void(results::Observer&)> work) {
  const std::lock_guard lock(mutex_);
  if (runs_) return false;
  if (thread_.joinable()) thread_.join();
  runs_ = true;
  cancelled_ = false;
  thread_ = std::thread([this, work = std::move(work)] {
    Json end = {{"ended", "done"}};
    try {
      Reporter reporter(tell_, cancelled_);
      work(reporter);
    } catch (const Cancelled&) {
      end = {{"ended", "cancelled"}};
    } catch (const std::exception& e) {
      end = {{"ended", "failed"}, {"why", results::printable(e.what())}};
    }
    runs_ = false;
    tell_(line_of(end));
  });
  return true;
}

}  // namespace gpvc::view
