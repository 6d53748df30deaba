#include "app/python/run_observer.h"

#include <utility>

#include "app/python/errors.h"

namespace gpvc::python {
namespace {

constexpr double kBetweenCalls = 0.1;  // s

}  // namespace

RunObserver::RunObserver(CancelFlag cancelled, py::object progress)
    : cancelled_(std::move(cancelled)), progress_(shared_object(std::move(progress))) {}

void RunObserver::begin(const results::StageInfo& stage) {
  check_cancelled();
  RunLog::begin(stage);
  tell(0, 0);
}

void RunObserver::progress(std::size_t done, std::size_t total) {
  check_cancelled();
  if (done >= total || seconds_since(told_) > kBetweenCalls) tell(done, total);
}

void RunObserver::end(const std::string& summary) {
  RunLog::end(summary);
  check_cancelled();
}

void RunObserver::warning(const std::string& text, const std::vector<Cure>& cures) {
  warnings_.push_back(with_arguments(text, cures));
}

void RunObserver::check_cancelled() {
  if (*cancelled_) throw Cancelled();
}

std::string RunObserver::json() const {
  return evaluate::json_text({{"stages", stages}, {"counts", counts}, {"notes", notes_}, {"warnings", warnings_}});
}

void RunObserver::tell(std::size_t done, std::size_t total) {
  told_ = Clock::now();
  const py::gil_scoped_acquire lock;
  if (!progress_->is_none()) (*progress_)(stage().name, done, total);
}

}  // namespace gpvc::python
